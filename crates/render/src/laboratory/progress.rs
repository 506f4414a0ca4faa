//! How far a search is on its way.

use std::sync::atomic::{AtomicU64, Ordering};

/// Is told, from any thread, the part of the way that is done: 0 to 1, by estimates that may fall a
/// little from one to the next.
pub type Tell<'a> = &'a (dyn Fn(f64) + Sync);

/// Tells of part `index` of `count` equal parts as of the whole.
pub(super) fn part_of(tell: Tell<'_>, index: usize, count: usize) -> impl Fn(f64) + Sync {
    move |done| tell((index as f64 + done) / count.max(1) as f64)
}

/// A round of paths on the way to an error.
pub(super) struct Round<'a> {
    tell: Tell<'a>,
    /// Paths that were traced before, and so many in all as the last error says will do.
    before: f64,
    expected: f64,
    done: AtomicU64,
}

impl<'a> Round<'a> {
    /// `short` is how many times as many paths as `before` are needed; infinite where nothing is known.
    pub(super) fn new(tell: Tell<'a>, before: u64, short: f64) -> Self {
        let before = before as f64;
        Self { tell, before, expected: before * short, done: AtomicU64::new(0) }
    }

    /// So many more paths are done.
    pub(super) fn add(&self, paths: u64) {
        let done = self.done.fetch_add(paths, Ordering::Relaxed) + paths;
        if self.expected.is_finite() && self.expected > 0.0 {
            (self.tell)(((self.before + done as f64) / self.expected).min(1.0));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    #[test]
    fn rounds_and_parts_tell_of_the_whole() {
        let told = Mutex::new(Vec::new());
        let tell = |done: f64| told.lock().unwrap().push(done);
        let second = part_of(&tell, 1, 2);
        let round = Round::new(&second, 20, 2.0);
        round.add(10);
        round.add(10);
        Round::new(&second, 0, f64::INFINITY).add(10);
        assert_eq!(*told.lock().unwrap(), [0.875, 1.0]);
    }
}
