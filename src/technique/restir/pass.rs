//! One pass over the pixels of a shot: candidates, the reservoirs of the pass before, a filter, those of neighbours, shading.

use std::f32::consts::TAU;

use glam::Vec3;
use rayon::prelude::*;

use super::boiling::BoilingFilter;
use super::candidates::Candidates;
use super::combine::{Combining, Offer};
use super::history::{History, Then};
use super::receiver::{Receiver, Surface};
use super::reservoir::Reservoir;
use super::settings::Settings;
use crate::sample::{Rng, additive};
use crate::technique::radiance::viewer_key;
use crate::technique::{Rendered, Shot};
use crate::trace::{Caster, RayCounter};

/// Key the random numbers of the stages; rounds of neighbours count on from the last.
const CANDIDATES: u64 = 0x7265_7374_0000;
const HISTORY: u64 = 0x7265_7374_0100;
const NEIGHBOURS: u64 = 0x7265_7374_0200;

/// Which lights there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sources {
    All,
    /// The map alone.
    Environment,
}

/// A pass under way.
pub struct Pass<'a> {
    pub shot: &'a Shot<'a>,
    pub settings: &'a Settings,
    pub sources: Sources,
    pub seed: u64,
    /// Of all passes of the viewer.
    pub number: u64,
    /// What each pixel shows.
    pub surfaces: &'a [Option<Surface>],
    /// The pass before.
    pub before: Option<&'a History>,
    /// Whether that was one frame earlier, so that things have moved since.
    pub moved: bool,
}

/// What happened to reservoirs, all told.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    /// Pixels whose surface the pass before showed.
    pub found: u64,
    /// Reservoirs of the pass before and of neighbours that were looked at.
    pub lookups: u64,
    /// Those of other surfaces, which were refused.
    pub rejected: u64,
    /// Those that the filter emptied.
    pub boiling: u64,
    pub non_finite: u64,
}

impl Tally {
    fn and(self, other: Self) -> Self {
        Self {
            found: self.found + other.found,
            lookups: self.lookups + other.lookups,
            rejected: self.rejected + other.rejected,
            boiling: self.boiling + other.boiling,
            non_finite: self.non_finite + other.non_finite,
        }
    }
}

/// What a pixel is worked on with.
struct Pixel<'p> {
    number: usize,
    surface: &'p Surface,
    receiver: Receiver<'p>,
}

impl<'a> Pass<'a> {
    /// Light that each pixel's surface scatters to the camera, not finite where something is not, and the reservoirs to
    /// remember. Time, rays and what happened go to `rendered`.
    pub fn run(&self, rendered: &mut Rendered, tally: &mut Tally) -> (Vec<Vec3>, Vec<Reservoir>) {
        let counter = RayCounter::default();
        let stages = &mut rendered.stages;
        let mut all = stages.time("candidates", || {
            let keys = [self.seed, viewer_key(self.shot), self.number];
            let candidates = Candidates::new(self.shot, self.settings, self.sources, keys);
            self.each(&counter, CANDIDATES, &mut *tally, &|pixel, _, tools| {
                candidates.reservoir(&pixel.receiver, tools)
            })
        });
        if let Some(before) = self.before.filter(|_| self.settings.history > 0) {
            let found = stages.time("reprojection", || self.found(before, &mut *tally));
            all = stages.time("temporal_reuse", || {
                self.each(&counter, HISTORY, &mut *tally, &|pixel, layer, tools| {
                    let found = found[pixel.number];
                    self.with_history(pixel, &all, layer, before, found, tools)
                })
            });
        }
        if self.settings.boiling > 0.0 {
            let filter = BoilingFilter {
                strength: self.settings.boiling,
                width: self.shot.width,
                layers: self.settings.reservoirs,
            };
            tally.boiling += stages.time("boiling_filter", || filter.run(&mut all));
        }
        for round in 0..u64::from(self.settings.rounds) {
            all = stages.time("spatial_reuse", || {
                let stream = NEIGHBOURS + round;
                self.each(&counter, stream, &mut *tally, &|pixel, layer, tools| {
                    self.with_neighbours(pixel, &all, layer, tools)
                })
            });
        }
        let light = stages.time("shading", || self.shaded(&all, &counter));
        rendered.rays += counter.read();
        (light, all)
    }

    /// Makes the reservoirs of all pixels anew; pixels without a surface have empty ones.
    fn each(
        &self,
        counter: &RayCounter,
        stream: u64,
        tally: &mut Tally,
        make: &(impl Fn(&Pixel, usize, Tools) -> Reservoir + Sync),
    ) -> Vec<Reservoir> {
        let layers = self.settings.reservoirs;
        let mut all = vec![Reservoir::default(); self.surfaces.len() * layers];
        let stream = stream ^ viewer_key(self.shot);
        let made = all
            .par_chunks_mut(layers)
            .zip(self.surfaces)
            .enumerate()
            .with_min_len(64)
            .map_init(
                || self.shot.tracer.caster(counter),
                |caster, (number, (reservoirs, surface))| {
                    let mut tally = Tally::default();
                    let Some(surface) = surface else {
                        return tally;
                    };
                    let pixel = Pixel {
                        number,
                        surface,
                        receiver: Receiver::new(self.shot, surface),
                    };
                    for (layer, reservoir) in reservoirs.iter_mut().enumerate() {
                        let item = (number * layers + layer) as u64;
                        let tools = Tools {
                            caster,
                            rng: Rng::new(self.seed, stream, item, self.number),
                            tally: &mut tally,
                        };
                        *reservoir = make(&pixel, layer, tools);
                    }
                    tally
                },
            )
            .reduce(Tally::default, Tally::and);
        *tally = tally.and(made);
        all
    }

    /// The pixel of the pass before that showed each surface.
    fn found(&self, before: &History, tally: &mut Tally) -> Vec<Option<usize>> {
        let moment = &self.shot.moment;
        let then: Vec<Option<Then>> = self
            .surfaces
            .par_iter()
            .with_min_len(64)
            .map(|surface| {
                let surface = surface.as_ref()?;
                let position = match self.moved {
                    true => moment.before(&surface.hit),
                    false => Receiver::new(self.shot, surface).position(),
                };
                let tolerances = self.settings.tolerances;
                Some(before.showing(position, surface.normal, tolerances))
            })
            .collect();
        let layers = self.settings.reservoirs as u64;
        let pixel = |then: Option<Then>| match then? {
            Then::Pixel(pixel) => {
                tally.found += 1;
                tally.lookups += layers;
                Some(pixel)
            }
            Then::Other => {
                tally.lookups += layers;
                tally.rejected += layers;
                None
            }
            Then::Outside => None,
        };
        then.into_iter().map(pixel).collect()
    }

    fn combining(&self) -> Combining<'_> {
        Combining {
            shot: self.shot,
            settings: self.settings,
        }
    }

    fn with_history(
        &self,
        pixel: &Pixel,
        all: &[Reservoir],
        layer: usize,
        before: &History,
        found: Option<usize>,
        mut tools: Tools,
    ) -> Reservoir {
        let layers = self.settings.reservoirs;
        let own = all[pixel.number * layers + layer];
        let then = found.and_then(|found| {
            let mut reservoir = *before.reservoirs.get(found * layers + layer)?;
            let most = self.settings.history.saturating_mul(own.count);
            reservoir.count = reservoir.count.min(most);
            let surface = before.surfaces[found]?;
            Some(Offer { reservoir, surface })
        });
        match then {
            Some(then) => self.combined(pixel, own, &[then], &mut tools),
            None => own,
        }
    }

    fn with_neighbours(
        &self,
        pixel: &Pixel,
        all: &[Reservoir],
        layer: usize,
        mut tools: Tools,
    ) -> Reservoir {
        let settings = self.settings;
        let layers = settings.reservoirs;
        let own = all[pixel.number * layers + layer];
        let count = settings.neighbours_of(&own);
        let shifts = [0; 3].map(|_| tools.rng.next_f64());
        let mut offers = Vec::with_capacity(count as usize);
        for number in (0..count).filter_map(|i| self.neighbour(pixel.number, shifts, i)) {
            tools.tally.lookups += 1;
            let Surface { normal, depth, .. } = *pixel.surface;
            let alike = |s: &Surface| s.resembles(normal, depth, settings.tolerances);
            let reservoir = all[number * layers + layer];
            match self.surfaces[number].filter(alike) {
                Some(surface) if settings.is_shared(&reservoir) => {
                    offers.push(Offer { reservoir, surface });
                }
                Some(_) => {}
                None => tools.tally.rejected += 1,
            }
        }
        match offers.is_empty() {
            true => own,
            false => self.combined(pixel, own, &offers, &mut tools),
        }
    }

    fn combined(
        &self,
        pixel: &Pixel,
        own: Reservoir,
        others: &[Offer],
        tools: &mut Tools,
    ) -> Reservoir {
        let combining = self.combining();
        let (reservoir, non_finite) =
            combining.combined(&pixel.receiver, own, others, tools.caster, &mut tools.rng);
        tools.tally.non_finite += non_finite;
        reservoir
    }

    /// Neighbour `i` of a pixel: well spread over the disk around it; `None` off the image and for the pixel itself.
    fn neighbour(&self, pixel: usize, shifts: [f64; 3], i: u32) -> Option<usize> {
        let [width, height] = [self.shot.width, self.shot.height];
        let [u, v, _] = additive(shifts, i);
        let distance = self.settings.radius(height) * u.sqrt();
        let (sin, cos) = (TAU * v).sin_cos();
        let along = |at: usize, step: f32, side: usize| {
            let at = at as i64 + i64::from(step.round() as i32);
            usize::try_from(at).ok().filter(|at| *at < side)
        };
        let x = along(pixel % width, distance * cos, width)?;
        let y = along(pixel / width, distance * sin, height)?;
        let neighbour = y * width + x;
        (neighbour != pixel).then_some(neighbour)
    }

    /// Light of the reservoirs' samples at each pixel, the mean of its reservoirs.
    fn shaded(&self, all: &[Reservoir], counter: &RayCounter) -> Vec<Vec3> {
        let layers = self.settings.reservoirs;
        let is_seen = self.settings.sees_shadows() && self.settings.visibility_reuse;
        let shade = |caster: &mut Caster, receiver: &Receiver, reservoir: &Reservoir| {
            let place = reservoir.place.as_ref()?;
            let (scattered, arriving) = receiver.scattered(place)?;
            let lit = is_seen || !self.shot.paths.occluded(caster, &arriving.shadow_ray);
            lit.then_some(scattered * reservoir.weight)
        };
        all.par_chunks(layers)
            .zip(self.surfaces)
            .with_min_len(64)
            .map_init(
                || self.shot.tracer.caster(counter),
                |caster, (reservoirs, surface)| {
                    let Some(surface) = surface else {
                        return Vec3::ZERO;
                    };
                    let receiver = Receiver::new(self.shot, surface);
                    let lit = reservoirs
                        .iter()
                        .filter_map(|r| shade(caster, &receiver, r));
                    lit.sum::<Vec3>() / layers as f32
                },
            )
            .collect()
    }
}

/// What making a reservoir takes.
pub struct Tools<'t> {
    pub caster: &'t Caster<'t>,
    pub rng: Rng,
    pub tally: &'t mut Tally,
}
