//! Pieces of a pack brought into touch: ice sticks, and a piece that touches nothing would float.

use super::relax::Spheres;
use snowgrain_math::DVec3;

/// Widest gaps, in mean radii, over which pieces are moved, round by round; in each a piece moves at most
/// once.
const GAPS: [f64; 12] = [0.1, 0.1, 0.2, 0.4, 0.8, 1.5, 3.0, 3.0, 6.0, 6.0, 6.0, 6.0];
/// Part of all spheres in the largest piece at which the rest may float.
const ENOUGH: f64 = 0.995;

impl Spheres {
    /// Moves each piece, smallest first, in a straight line towards the nearest sphere of another
    /// until it touches one. Spheres touch whose surfaces are no more than `touch` apart; pieces that hold one of the
    /// first `fixed` spheres stay.
    pub(super) fn attach(&mut self, touch: f64, fixed: usize) {
        let mean = self.radii.iter().sum::<f64>() / self.radii.len().max(1) as f64;
        for gap in GAPS.map(|gap| gap * mean) {
            let pieces = self.pieces(touch);
            let largest = pieces.iter().map(Vec::len).max().unwrap_or(0);
            if largest as f64 >= ENOUGH * self.centers.len() as f64 {
                return;
            }
            let mut piece_of = vec![0; self.centers.len()];
            for (number, piece) in pieces.iter().enumerate() {
                piece.iter().for_each(|&sphere| piece_of[sphere as usize] = number);
            }
            let mut order: Vec<usize> = (0..pieces.len()).collect();
            order.sort_by_key(|&number| (pieces[number].len(), number));
            let main = order.last().copied();
            // Twice as wide, as both may have moved.
            let near = self.neighbours_of(2.0 * gap, &|sphere| Some(piece_of[sphere]) != main);
            // What another has just come to rest on stays.
            let mut stays = vec![false; pieces.len()];
            order.pop();
            for number in order {
                let is_fixed = pieces[number].iter().any(|&sphere| (sphere as usize) < fixed);
                if stays[number] || is_fixed {
                    continue;
                }
                if let Some(onto) = self.move_piece(&pieces[number], &piece_of, &near, gap) {
                    (stays[number], stays[onto]) = (true, true);
                }
            }
        }
    }

    /// Spheres that hang together, by piece.
    fn pieces(&self, touch: f64) -> Vec<Vec<u32>> {
        let near = self.neighbours(touch);
        let mut seen = vec![false; near.len()];
        let mut pieces = Vec::new();
        for start in 0..near.len() {
            if std::mem::replace(&mut seen[start], true) {
                continue;
            }
            let mut piece = vec![start as u32];
            let mut at = 0;
            while let Some(&sphere) = piece.get(at) {
                at += 1;
                for &other in &near[sphere as usize] {
                    if !std::mem::replace(&mut seen[other as usize], true) {
                        piece.push(other);
                    }
                }
            }
            pieces.push(piece);
        }
        pieces
    }

    /// Moves a piece onto the nearest other, or whatever lies before it; gives the number of that piece.
    fn move_piece(
        &mut self,
        piece: &[u32],
        piece_of: &[usize],
        near: &[Vec<u32>],
        widest: f64,
    ) -> Option<usize> {
        let number = piece_of[piece[0] as usize];
        let others = |&sphere: &u32| {
            let a = sphere as usize;
            near[a].iter().map(move |&b| (a, b as usize)).filter(|&(_, b)| piece_of[b] != number)
        };
        let gap = |(a, b): (usize, usize)| self.distance(a, b) - self.radii[a] - self.radii[b];
        let (least, (a, b)) = piece
            .iter()
            .flat_map(others)
            .map(|pair| (gap(pair), pair))
            .min_by(|x, y| x.0.total_cmp(&y.0))
            .filter(|(least, _)| *least <= widest)?;
        let direction = self.towards(a, b).normalize();
        let mut first = (least.max(0.0), b);
        for (a, b) in piece.iter().flat_map(others) {
            if let Some(free) = self.free_path(a, b, direction)
                && free < first.0
            {
                first = (free, b);
            }
        }
        for &sphere in piece {
            self.centers[sphere as usize] += direction * first.0;
        }
        Some(piece_of[first.1])
    }

    /// How far sphere `a` can move along a direction until it meets `b`.
    fn free_path(&self, a: usize, b: usize, direction: DVec3) -> Option<f64> {
        let d = self.towards(a, b);
        let along = d.dot(direction);
        let reach = self.radii[a] + self.radii[b];
        let square = reach * reach - (d.length_squared() - along * along);
        (along > 0.0 && square > 0.0).then(|| (along - square.sqrt()).max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_floats_moves_to_the_nearest_and_takes_all_that_hangs_on_it_along() {
        let x = |x: f64| DVec3::new(x, 10.0, 10.0);
        let mut spheres = Spheres {
            // Three in a row, and two at a distance, one of them across the end of the box.
            centers: vec![x(4.0), x(6.0), x(8.0), x(18.5), x(20.5)],
            radii: vec![1.0; 5],
            period: DVec3::splat(20.0),
        };
        spheres.attach(1e-6, 0);
        assert_eq!(spheres.pieces(1e-6).len(), 1);
        assert!((spheres.distance(3, 4) - 2.0).abs() < 1e-9);
        assert!((spheres.distance(4, 0) - 2.0).abs() < 1e-9);
        assert_eq!(spheres.centers[..3], [x(4.0), x(6.0), x(8.0)]);
    }
}
