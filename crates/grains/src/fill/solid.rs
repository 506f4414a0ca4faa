//! The inside of a closed mesh.

use crate::GrainsError;
use snowgrain_accel::Extent;
use snowgrain_geometry::TriangleMesh;
use snowgrain_math::{Aabb, DVec3};
use std::collections::{BTreeMap, HashMap};

/// Most squares along an edge of the plan; there are about as many as triangles.
const MOST_SQUARES: f64 = 2048.0;

/// A closed mesh that can be asked whether a point lies inside: by its winding number, the sum over all
/// triangles above the point of the sense in which they are seen.
///
/// Whether a vertical line passes a triangle follows from crossings of its edges, each decided once for
/// both triangles that share it. So no line slips through between two triangles.
#[derive(Clone, Debug)]
pub struct Solid {
    /// Without doubles.
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    /// 1, or -1 where the mesh is inside out.
    sense: i32,
    bounds: Aabb,
    /// Cubic metres.
    volume: f64,
    squares: Squares,
}

/// Triangles by the squares of the plan that they may cover.
#[derive(Clone, Debug)]
struct Squares {
    counts: [usize; 2],
    size: [f64; 2],
    starts: Vec<u32>,
    triangles: Vec<u32>,
}

impl Solid {
    /// The inside of `mesh`.
    ///
    /// # Errors
    /// A mesh that is not closed: an edge that its triangles do not pass as often in one direction as in
    /// the other.
    pub fn new(mesh: &TriangleMesh) -> Result<Self, GrainsError> {
        let (positions, triangles) = welded(mesh);
        check_closed(&positions, &triangles)?;
        let bounds = positions.iter().fold(Aabb::EMPTY, |bounds, &at| bounds.including(at));
        let middle = bounds.center();
        let volume: f64 = triangles
            .iter()
            .map(|t| t.map(|v| positions[v as usize] - middle))
            .map(|[a, b, c]| a.dot(b.cross(c)))
            .sum();
        let squares = Squares::new(&positions, &triangles, &bounds);
        let sense = if volume < 0.0 { -1 } else { 1 };
        let volume = volume.abs() / 6.0;
        Ok(Self { positions, triangles, sense, bounds, volume, squares })
    }

    /// What lies between an open mesh and the level `base`, metres: the mesh is a surface of heights, which
    /// vertical walls along its rim and a floor close.
    ///
    /// # Errors
    /// A mesh that is closed, reaches below the level, or hangs over; as [`Self::new`].
    pub fn under(mesh: &TriangleMesh, base: f64) -> Result<Self, GrainsError> {
        let (top, mut triangles) = welded(mesh);
        face_up(&top, &mut triangles)?;
        if let Some(at) = top.iter().find(|at| at.y < base) {
            let reason = format!(
                "the mesh reaches to ({}, {}, {}) m, below the base of {base} m; lower that",
                at.x, at.y, at.z
            );
            return Err(GrainsError::setting("base", reason));
        }
        let rim = rim(&triangles);
        if rim.is_empty() {
            let reason = "the mesh is closed, and filled as it is; remove the base";
            return Err(GrainsError::setting("base", reason));
        }
        let below = top.len() as u32;
        let floor = triangles.iter().map(|&[a, b, c]| [c + below, b + below, a + below]);
        let walls = rim.iter().flat_map(|&[a, b]| [[b, a, a + below], [b, a + below, b + below]]);
        let all: Vec<[u32; 3]> = triangles.iter().copied().chain(floor).chain(walls).collect();
        let shadow = top.iter().map(|at| DVec3::new(at.x, base, at.z));
        let positions: Vec<DVec3> = top.iter().copied().chain(shadow).collect();
        Self::new(&TriangleMesh { positions, triangles: all, coordinates: Vec::new() })
    }

    /// The box around it, metres.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Its volume, cubic metres.
    #[must_use]
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// What of a box lies inside, where it is sure: where no triangle is near, all of it does or none.
    pub(super) fn extent(&self, around: &Aabb) -> Extent {
        let is_near = |triangle: u32| {
            let [a, b, c] = self.triangles[triangle as usize].map(|v| self.positions[v as usize]);
            let (low, high) = (a.min(b).min(c), a.max(b).max(c));
            low.cmple(around.max).all() && high.cmpge(around.min).all()
        };
        if self.squares.over(&self.bounds, around).any(is_near) {
            return Extent::Part;
        }
        match self.holds(around.center()) {
            Ok(true) => Extent::Whole,
            Ok(false) => Extent::Empty,
            Err(_) => Extent::Part,
        }
    }

    /// Whether a point, metres, lies inside.
    ///
    /// # Errors
    /// A point that lies inside more than once, or inside out: the mesh crosses itself.
    pub fn holds(&self, point: DVec3) -> Result<bool, GrainsError> {
        let within = point.cmpge(self.bounds.min).all() && point.cmple(self.bounds.max).all();
        if !within {
            return Ok(false);
        }
        let above = self.squares.at(&self.bounds, point).iter();
        let winding: i32 = above.map(|&triangle| self.passed(triangle, point)).sum();
        match winding * self.sense {
            0 => Ok(false),
            1 => Ok(true),
            _ => Err(GrainsError::setting(
                "file",
                format!(
                    "the mesh crosses itself: ({}, {}, {}) m lies inside it more than once; unite its \
                     parts first",
                    point.x, point.y, point.z
                ),
            )),
        }
    }

    /// 1 or -1 where a line up from `point` leaves or enters through a triangle, else 0.
    fn passed(&self, triangle: u32, point: DVec3) -> i32 {
        let corners = self.triangles[triangle as usize];
        let [a, b, c] = corners.map(|v| self.positions[v as usize]);
        if a.y.max(b.y).max(c.y) < point.y {
            return 0;
        }
        let [i, j, k] = corners;
        let edges = [[i, j], [j, k], [k, i]];
        let turns: i32 = edges.into_iter().map(|edge| self.crosses(edge, point)).sum();
        if turns == 0 {
            return 0;
        }
        // The height of the triangle's plane over the point.
        let normal = (b - a).cross(c - a);
        let height = if normal.y == 0.0 {
            a.y.max(b.y).max(c.y)
        } else {
            a.y - (normal.x * (point.x - a.x) + normal.z * (point.z - a.z)) / normal.y
        };
        if height > point.y { turns } else { 0 }
    }

    /// Whether an edge crosses, on the plan, the line from the point towards greater x: 1 or -1 by the
    /// sense in which it turns about the point, so that 1 is that of triangles which face up.
    fn crosses(&self, [from, to]: [u32; 2], point: DVec3) -> i32 {
        let (low, high) = (from.min(to), from.max(to));
        let [a, b] = [low, high].map(|v| self.positions[v as usize]);
        let rises = i32::from(a.z <= point.z) - i32::from(b.z <= point.z);
        if rises == 0 {
            return 0;
        }
        let side = (b.x - a.x) * (point.z - a.z) - (point.x - a.x) * (b.z - a.z);
        let crosses = if rises > 0 { side > 0.0 } else { side <= 0.0 };
        match (crosses, from < to) {
            (false, _) => 0,
            (true, true) => -rises,
            (true, false) => rises,
        }
    }
}

/// Positions without doubles, and the triangles whose corners are three of them.
fn welded(mesh: &TriangleMesh) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut numbers: HashMap<[u64; 3], u32> = HashMap::new();
    let mut positions = Vec::new();
    let number_of = |&at: &DVec3| {
        // -0 is 0.
        let bits = (at + 0.0).to_array().map(f64::to_bits);
        *numbers.entry(bits).or_insert_with(|| {
            positions.push(at);
            positions.len() as u32 - 1
        })
    };
    let number: Vec<u32> = mesh.positions.iter().map(number_of).collect();
    let corners = mesh.triangles.iter().map(|corners| corners.map(|v| number[v as usize]));
    let triangles = corners.filter(|[a, b, c]| a != b && b != c && c != a).collect();
    (positions, triangles)
}

/// Turns the triangles of a surface of heights up.
///
/// # Errors
/// Triangles of which some face up and others down.
fn face_up(positions: &[DVec3], triangles: &mut [[u32; 3]]) -> Result<(), GrainsError> {
    let on_plan = |corners: [u32; 3]| {
        let [a, b, c] = corners.map(|v| positions[v as usize]);
        (b - a).cross(c - a).y
    };
    let whole: f64 = triangles.iter().map(|&corners| on_plan(corners)).sum();
    if whole < 0.0 {
        triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
    }
    let Some(&[corner, ..]) = triangles.iter().find(|&&corners| on_plan(corners) < 0.0) else {
        return Ok(());
    };
    let at = positions[corner as usize];
    let reason = format!(
        "the open mesh hangs over, or its triangles face different ways, at ({}, {}, {}) m; heights have one \
         surface over each place: close the mesh, or unify its normals",
        at.x, at.y, at.z
    );
    Err(GrainsError::setting("file", reason))
}

/// The edges that one triangle passes and none passes back, as it passes them.
fn rim(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let mut balance: BTreeMap<[u32; 2], i32> = BTreeMap::new();
    for &[a, b, c] in triangles {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            *balance.entry([from.min(to), from.max(to)]).or_default() +=
                if from < to { 1 } else { -1 };
        }
    }
    let passed = balance.into_iter().filter(|(_, passes)| *passes != 0);
    passed.map(|([low, high], passes)| if passes > 0 { [low, high] } else { [high, low] }).collect()
}

/// # Errors
/// An edge that is not passed as often in both directions.
fn check_closed(positions: &[DVec3], triangles: &[[u32; 3]]) -> Result<(), GrainsError> {
    let mut edges: Vec<(u32, u32, i32)> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[from, to]| if from < to { (from, to, 1) } else { (to, from, -1) })
        .collect();
    edges.sort_unstable();
    let is_open = |same: &&[(u32, u32, i32)]| same.iter().map(|edge| edge.2).sum::<i32>() != 0;
    let open = edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)).find(is_open);
    let Some(&[(from, to, _), ..]) = open else { return Ok(()) };
    let [a, b] = [from, to].map(|v| positions[v as usize]);
    Err(GrainsError::setting(
        "file",
        format!(
            "the mesh is not closed: the edge from ({}, {}, {}) to ({}, {}, {}) m has no second side, \
             or its triangles face different ways; close its holes and unify its normals, or say the base \
             that a surface of heights stands on",
            a.x, a.y, a.z, b.x, b.y, b.z
        ),
    ))
}

impl Squares {
    fn new(positions: &[DVec3], triangles: &[[u32; 3]], bounds: &Aabb) -> Self {
        let size = bounds.size();
        let edge = (size.x * size.z / triangles.len().max(1) as f64).sqrt();
        let counts =
            [size.x, size.z].map(|length| (length / edge).ceil().clamp(1.0, MOST_SQUARES) as usize);
        let size = [size.x / counts[0] as f64, size.z / counts[1] as f64];
        let mut squares = Self { counts, size, starts: Vec::new(), triangles: Vec::new() };
        let range = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            let (low, high) = (a.min(b).min(c), a.max(b).max(c));
            [squares.place(bounds, low), squares.place(bounds, high)]
        };
        let ranges: Vec<[[usize; 2]; 2]> = triangles.iter().map(range).collect();
        let covered = |&[low, high]: &[[usize; 2]; 2]| {
            let rows = low[1]..=high[1];
            rows.flat_map(move |row| (low[0]..=high[0]).map(move |x| row * counts[0] + x))
        };
        let mut starts = vec![0u32; counts[0] * counts[1] + 1];
        ranges.iter().flat_map(covered).for_each(|square| starts[square + 1] += 1);
        for square in 1..starts.len() {
            starts[square] += starts[square - 1];
        }
        let mut next = starts.clone();
        let mut listed = vec![0; starts.last().map_or(0, |&all| all as usize)];
        for (triangle, range) in (0u32..).zip(&ranges) {
            for square in covered(range) {
                listed[next[square] as usize] = triangle;
                next[square] += 1;
            }
        }
        (squares.starts, squares.triangles) = (starts, listed);
        squares
    }

    fn place(&self, bounds: &Aabb, at: DVec3) -> [usize; 2] {
        let [x, z] = [(at.x - bounds.min.x) / self.size[0], (at.z - bounds.min.z) / self.size[1]];
        [(x as usize).min(self.counts[0] - 1), (z as usize).min(self.counts[1] - 1)]
    }

    /// The triangles of all squares that a box covers on the plan; some of them more than once.
    fn over(&self, bounds: &Aabb, around: &Aabb) -> impl Iterator<Item = u32> + '_ {
        let [low, high] = [around.min, around.max].map(|end| self.place(bounds, end));
        (low[1]..=high[1]).flat_map(move |row| (low[0]..=high[0]).map(move |x| [x, row])).flat_map(
            |[column, row]| {
                let square = row * self.counts[0] + column;
                let range = self.starts[square] as usize..self.starts[square + 1] as usize;
                self.triangles[range].iter().copied()
            },
        )
    }

    fn at(&self, bounds: &Aabb, point: DVec3) -> &[u32] {
        let [column, row] = self.place(bounds, point);
        let square = row * self.counts[0] + column;
        &self.triangles[self.starts[square] as usize..self.starts[square + 1] as usize]
    }
}
