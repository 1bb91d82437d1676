//! The layers of an image by path tracing, one random estimate a sample.

use glam::Vec3;

use super::{Seen, ShadingFunction, Shot, each_pixel};
use crate::entry::words;
use crate::sample::{Rng, additive, hash};
use crate::shade::Depths;
use crate::trace::Caster;

/// Keys the paths of direct and of indirect light.
const STREAMS: [u64; 2] = [0x6469_7265_6374, 0x696e_6469_7265];

words! {
    /// What of the light is in an image.
    pub enum Layer {
        /// Light scattered at least twice.
        Indirect = "indirect",
        /// All light: emission and direct light added.
        Global = "global",
    }
}

/// Rays of one sample in the shipped scenes, about, for cost estimates.
pub const RAYS_PER_SAMPLE: u64 = 6;
/// Paths end at random from here on.
const ROULETTE_FROM: u32 = 2;

/// Light paths from a surface that the camera sees: those of at least two scatterings, in a scene
/// that follows paths of `max_depth` edges.
pub fn indirect(shot: &Shot) -> Depths {
    Depths {
        first: 2,
        last: shot.scene.max_depth.saturating_sub(1),
        roulette_from: Some(ROULETTE_FROM),
        hides_sky: false,
    }
}

/// One estimate of a layer for each pixel and pass.
pub struct LayerPaths<'a> {
    pub shot: &'a Shot<'a>,
    /// Whether emission and direct light are in.
    pub direct: bool,
    /// Paths from the surface that the camera sees on; `None` leaves indirect light out.
    pub indirect: Option<Depths>,
    pub seed: u64,
}

impl ShadingFunction for LayerPaths<'_> {
    fn pixels(&self, caster: &Caster, first_pixel: u32, pass: u32, out: &mut [[f32; 3]]) -> u64 {
        let shot = self.shot;
        each_pixel(first_pixel, out, |pixel| {
            match shot.look_out(caster, pixel, pass % shot.spp) {
                Ok(seen) => seen.throughput * self.shaded(caster, &seen, pass),
                Err(missed) if self.direct => {
                    missed.throughput * shot.paths.lights().environment(missed.direction)
                }
                Err(_) => Vec3::ZERO,
            }
        })
    }
}

impl LayerPaths<'_> {
    fn shaded(&self, caster: &Caster, seen: &Seen, pass: u32) -> Vec3 {
        let paths = &self.shot.paths;
        let at = self.shot.surface(seen);
        let mut sum = Vec3::ZERO;
        if self.direct {
            let mut rng = self.rng(STREAMS[0], seen.pixel, pass);
            sum += paths.direct(caster, &at, &mut rng);
        }
        if let Some(depths) = self.indirect {
            let mut rng = self.rng(STREAMS[1], seen.pixel, pass);
            let key = hash(self.seed ^ STREAMS[1]) ^ u64::from(seen.pixel);
            if let Some(sample) = at.sample(spread(key, pass)) {
                let ray = paths.lights().spawn(&at, sample.direction);
                let radiance = paths.radiance(caster, ray, &mut rng, depths);
                sum += sample.weight * Vec3::from(radiance);
            }
        }
        sum
    }

    fn rng(&self, stream: u64, pixel: u32, pass: u32) -> Rng {
        Rng::new(self.seed, stream, u64::from(pixel), u64::from(pass))
    }
}

/// Point `pass` of the additive sequence, shifted for each pixel: successive passes spread the first
/// scattering evenly.
fn spread(key: u64, pass: u32) -> [f32; 3] {
    additive(
        [1, 2, 3].map(|axis| Rng::new(key, axis, 0, 0).next_f64()),
        pass,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::luminance;
    use crate::scene::{ColourSource, Needs, Scene, find_scene};
    use crate::technique::Film;
    use crate::trace::{RayCounter, Tracer};
    use crate::world::Moment;

    /// Whether a sample passes a mask is decided where the camera looks, and not again where it shades.
    #[test]
    fn a_half_transparent_scene_is_what_paths_from_the_camera_see() {
        const PASSES: u32 = 128;
        let mut description = find_scene("still-puzzle").expect("an embedded scene");
        for material in &mut description.materials {
            material.opacity = Some(ColourSource::Constant([0.5; 3]));
        }
        let scene = Scene::build(&description, Needs::ALL).expect("a scene");
        let tracer = Tracer::new(&scene.positions, &scene.triangles);
        let film = Film {
            width: 16,
            height: 12,
            spp: PASSES,
        };
        let shot = Shot::new(Moment::still(&scene, &tracer), &scene.views[0], film);
        let layers = LayerPaths {
            shot: &shot,
            direct: true,
            indirect: Some(indirect(&shot)),
            seed: 1,
        };
        let counter = RayCounter::default();
        let caster = tracer.caster(&counter);
        let (mut by_layers, mut by_paths) = (0.0, 0.0);
        for pass in 0..PASSES {
            let mut out = vec![[0.0; 3]; shot.pixels()];
            layers.pixels(&caster, 0, pass, &mut out);
            for (pixel, value) in (0..).zip(out) {
                let ray = shot.camera_ray(pixel, pass);
                let mut rng = Rng::new(2, 0, u64::from(pixel), u64::from(pass));
                let depths = Depths::up_to(shot.scene.max_depth);
                by_layers += luminance(value);
                by_paths += luminance(shot.paths.radiance(&caster, ray, &mut rng, depths));
            }
        }
        let difference = by_layers / by_paths - 1.0;
        assert!(difference.abs() < 0.02, "{difference}");
    }
}
