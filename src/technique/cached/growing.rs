//! The records of a job while a refinement adds to them.

use glam::Vec3;
use rayon::prelude::*;

use super::{CachedFunction, select};
use crate::cache::ShadingPoints;
use crate::placement;
use crate::technique::{Seen, Site, Stages};
use crate::trace::RayCounter;

/// The records of a job while a refinement adds to them.
pub(super) struct Growing<'a, 'f> {
    function: &'a mut (dyn CachedFunction + 'f),
    points: &'a ShadingPoints,
    /// Of each point; empty if nothing is predicted.
    importance: Vec<Vec3>,
    counter: &'a RayCounter,
    /// How many were added.
    pub added: usize,
    /// Time taken by adding.
    pub stages: Stages,
}

impl<'a, 'f> Growing<'a, 'f> {
    /// The records that a function holds.
    pub fn new(
        function: &'a mut (dyn CachedFunction + 'f),
        points: &'a ShadingPoints,
        counter: &'a RayCounter,
    ) -> Self {
        Self {
            function,
            points,
            importance: Vec::new(),
            counter,
            added: 0,
            stages: Stages::default(),
        }
    }

    /// Works out how much each point matters, which predictions need.
    pub fn weigh(&mut self) {
        let (function, points) = (&*self.function, self.points);
        self.importance = (0..points.len() as u32)
            .into_par_iter()
            .with_min_len(1024)
            .map(|i| function.importance(&Seen::of(points, i)))
            .collect();
    }
}

impl placement::Records for Growing<'_, '_> {
    fn difference(&self, a: u32, b: u32) -> f32 {
        self.function.difference(a, b)
    }

    fn predict(&self, record: u32, point: u32) -> (Vec3, f32) {
        let (value, trust) = self.function.predict(record, &Site::of(self.points, point));
        (value * self.importance[point as usize], trust)
    }

    fn add(&mut self, points: &[u32]) {
        let sites = select(self.points, points);
        let (function, counter) = (&mut *self.function, self.counter);
        let evaluate = || function.evaluate(&sites, counter);
        self.stages.time("evaluation", evaluate);
        self.added += points.len();
    }
}
