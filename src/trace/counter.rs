//! Counted work: the cost that does not depend on the machine.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Rays of one job, added up from all threads.
#[derive(Debug, Default)]
pub struct RayCounter {
    closest: AtomicU64,
    shadow: AtomicU64,
    refused: AtomicU64,
}

/// A reading of a [`RayCounter`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounts {
    /// Closest-hit rays.
    pub closest: u64,
    /// Any-hit (occlusion) rays.
    pub shadow: u64,
    /// Rays among them that were not finite and therefore hit nothing.
    pub refused: u64,
}

impl std::ops::AddAssign for RayCounts {
    fn add_assign(&mut self, other: Self) {
        self.closest += other.closest;
        self.shadow += other.shadow;
        self.refused += other.refused;
    }
}

impl RayCounts {
    /// Rays of either kind.
    pub fn all(self) -> u64 {
        self.closest + self.shadow
    }
}

impl RayCounter {
    /// Adds rays that were counted elsewhere.
    pub fn add(&self, counts: RayCounts) {
        self.closest.fetch_add(counts.closest, Relaxed);
        self.shadow.fetch_add(counts.shadow, Relaxed);
        self.refused.fetch_add(counts.refused, Relaxed);
    }

    /// What was counted so far.
    pub fn read(&self) -> RayCounts {
        RayCounts {
            closest: self.closest.load(Relaxed),
            shadow: self.shadow.load(Relaxed),
            refused: self.refused.load(Relaxed),
        }
    }
}
