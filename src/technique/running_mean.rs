//! The contender `running-mean` of path tracing and direct lighting: the paths of a frame, averaged with what the frames before
//! showed of the same surface points.
//!
//! The surface at the centre of each pixel is looked up in the frame before: its point then is projected with the camera
//! then, and the pixel found is taken if it showed a point nearby with a similar normal; where no surface is seen, the pixel in that direction is taken. The mean over frames is a
//! running one, `m ← m + (x − m)/n` with `n` counted up to the window, so that a still camera over a still
//! scene gives the mean of all paths of the last frames.

use glam::Vec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::path_samples::sampled;
use super::truth::Truth;
use super::{Contender, ContenderEntry, Rendered, Shot, Site, Terms};
use crate::entry::{About, Bias, parameters};
use crate::image::Image;
use crate::scene::View;
use crate::trace::RayCounter;

/// Entry in the list of their contenders.
pub const ENTRY: ContenderEntry<Truth> = ContenderEntry {
    about: About {
        id: "running-mean",
        module: crate::entry::head_comment!("running_mean.rs"),
        aliases: &["temporal"],
        summary: "paths averaged with those of earlier frames by reprojection",
        source: "Nehab et al. 2007; Scherzer et al. 2007: reverse reprojection",
        bias: Bias::Biased,
        version: 1,
        failures: &[
            "light and reflections that change with time or view trail behind",
            "a moving camera blurs, because the nearest pixel of the frame before is taken",
        ],
        parameters: Parameters::PARAMETERS,
    },
    start: |technique, table, terms| {
        Ok(Box::new(RunningMean {
            technique,
            parameters: Parameters::read(table)?,
            terms,
            histories: Vec::new(),
        }))
    },
};

parameters! {
    #[derive(Clone, Copy, Debug)]
    struct Parameters {
        /// Frames that the running mean weighs at most.
        window: u32 = 32, Within(1.0, 65536.0), "frames";
        /// Largest distance of the point shown before, in projected pixels.
        tolerance: f32 = 2.0, Above(0.0), "pixels";
    }
}

/// Least cosine of the normals of a point then and now.
const LEAST_COSINE: f32 = 0.9;

struct RunningMean<'a> {
    technique: &'a Truth,
    parameters: Parameters,
    terms: Terms,
    /// Of each viewer, by its number.
    histories: Vec<Option<History>>,
}

/// What a viewer saw one frame earlier.
#[derive(Serialize, Deserialize)]
struct History {
    view: View,
    size: [usize; 2],
    /// What each pixel showed.
    pixels: Vec<Remembered>,
}

/// What a pixel showed: the surface at its centre, if any, and its mean over frames.
#[derive(Clone, Copy, Serialize, Deserialize)]
struct Remembered {
    site: Option<Site>,
    mean: [f32; 3],
    frames: f32,
}

impl Contender for RunningMean<'_> {
    fn remembers(&self) -> bool {
        true
    }

    fn memory(&self) -> Result<Vec<u8>, String> {
        postcard::to_allocvec(&self.histories).map_err(|error| error.to_string())
    }

    fn recall(&mut self, memory: &[u8]) -> Result<(), String> {
        if !memory.is_empty() {
            self.histories = postcard::from_bytes(memory).map_err(|error| error.to_string())?;
        }
        Ok(())
    }

    fn frame(&mut self, shots: &[Shot]) -> Result<Vec<Rendered>, String> {
        Ok(shots.iter().map(|shot| self.shot(shot)).collect())
    }
}

impl RunningMean<'_> {
    fn shot(&mut self, shot: &Shot) -> Rendered {
        let samples = self.terms.budget as u32;
        let paths = self.technique.contender_paths(shot, self.terms.seed);
        // Each frame takes the next paths, or a still camera would average the same ones.
        let first = shot.frame.wrapping_mul(samples);
        let mut rendered = sampled(shot, &paths, first, samples);
        let viewer = usize::from(shot.viewer);
        if self.histories.len() <= viewer {
            self.histories.resize_with(viewer + 1, || None);
        }
        let before = self.histories[viewer].take();
        let counter = RayCounter::default();
        let mut stages = std::mem::take(&mut rendered.stages);
        let pixels = stages.time("reprojection", || {
            self.merge(shot, &rendered.image, before.as_ref(), &counter)
        });
        rendered.stages = stages;
        rendered.rays += counter.read();
        for (pixel, remembered) in rendered.image.pixels.iter_mut().zip(&pixels) {
            *pixel = remembered.mean;
        }
        let reused = pixels.iter().filter(|p| p.frames > 1.0).count();
        let share = reused as f64 / pixels.len().max(1) as f64;
        rendered.found.push(("reprojected", share));
        rendered.bytes_cache = size_of_val(pixels.as_slice());
        self.histories[viewer] = Some(History {
            view: shot.view.clone(),
            size: [shot.width, shot.height],
            pixels,
        });
        rendered
    }

    /// The frame's means merged with those of the frame before.
    fn merge(
        &self,
        shot: &Shot,
        image: &Image,
        before: Option<&History>,
        counter: &RayCounter,
    ) -> Vec<Remembered> {
        let [_, half] = shot.view.half_tangents(shot.width, shot.height);
        let pixel_angle = (2.0 * half / shot.height as f64) as f32;
        let mut merged = Vec::with_capacity(image.pixels.len());
        image
            .pixels
            .par_iter()
            .enumerate()
            .with_min_len(256)
            .map_init(
                || shot.tracer.caster(counter),
                |caster, (pixel, &value)| {
                    let mut now = Remembered {
                        site: None,
                        mean: value,
                        frames: 1.0,
                    };
                    let then = match shot.look(caster, pixel as u32, 0) {
                        Some(seen) => {
                            now.site = Some(seen.site);
                            let nearby = self.parameters.tolerance * pixel_angle * seen.depth;
                            let old = Site {
                                position: shot.moment.before(&seen.hit),
                                ..seen.site
                            };
                            before.and_then(|b| b.showing(&old, nearby))
                        }
                        None => {
                            let direction = shot.camera_ray(pixel as u32, 0).direction;
                            before.and_then(|b| b.open_towards(direction))
                        }
                    };
                    if let Some(then) = then {
                        now.frames = (then.frames + 1.0).min(self.parameters.window as f32);
                        let (mean, value) = (Vec3::from(then.mean), Vec3::from(value));
                        now.mean = (mean + (value - mean) / now.frames).into();
                    }
                    now
                },
            )
            .collect_into_vec(&mut merged);
        merged
    }
}

impl History {
    /// The pixel that looked in a direction, if it saw no surface.
    fn open_towards(&self, direction: Vec3) -> Option<&Remembered> {
        let [x, y] = self
            .view
            .project(self.view.origin + direction.as_dvec3(), self.size)?;
        let pixel = &self.pixels[y as usize * self.size[0] + x as usize];
        pixel.site.is_none().then_some(pixel)
    }

    /// The pixel that showed a surface point, if its own lies within `nearby` (scene units).
    fn showing(&self, site: &Site, nearby: f32) -> Option<&Remembered> {
        let [x, y] = self.view.project(site.position.as_dvec3(), self.size)?;
        let pixel = &self.pixels[y as usize * self.size[0] + x as usize];
        let then = pixel.site?;
        let same = then.position.distance(site.position) <= nearby
            && then.normal.dot(site.normal) >= LEAST_COSINE;
        same.then_some(pixel)
    }
}
