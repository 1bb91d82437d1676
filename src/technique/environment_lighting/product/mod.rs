//! Product-ratio sampling of the map (see [`crate::environment::product_ratio`]): lights chosen at
//! every shading point, and their visibility as a filtered ratio.

mod contributions;
mod film;
mod filter;
mod gather;
mod irradiance;
mod lights;
mod numbers;
mod selection;
mod terms;
#[cfg(test)]
mod tests;

use glam::Vec3;

use super::super::{Rendered, Terms};
use super::illumination::Illumination;
use crate::environment::TexelLights;
use crate::environment::product_ratio::ProductRatio;
use crate::image::Image;
use crate::memory::released;
use crate::trace::RayCounter;
use contributions::Detail;
use film::Film;
use gather::Gather;
use irradiance::Irradiance;
use lights::LightArrays;
use numbers::PixelNumbers;

/// Renders an image.
pub(super) fn render(
    illumination: &Illumination,
    parameters: &ProductRatio,
    unbiased: bool,
    terms: &Terms,
    counter: &RayCounter,
) -> Rendered {
    let shot = illumination.shot;
    let mut rendered = Rendered::default();
    let map = illumination.environment.for_lights();
    let (mut lights, arrays, irradiance) = rendered.stages.time("light_generation", || {
        let generate = match unbiased {
            true => TexelLights::with_texels,
            false => TexelLights::new,
        };
        let lights = generate(&map, parameters.lights, terms.seed);
        let arrays = LightArrays::new(&lights, illumination.scale);
        let irradiance = Irradiance::new(&arrays);
        (lights, arrays, irradiance)
    });
    let mut sums = vec![Vec3::ZERO; shot.pixels()];
    let mut film = Film::new([shot.width, shot.height], parameters);
    for sample in 0..shot.spp {
        let gather = Gather {
            illumination,
            map: &map,
            lights: &lights,
            arrays: &arrays,
            irradiance: &irradiance,
            detail: match unbiased {
                true => Detail::All,
                false => Detail::Highlights(parameters.detail),
            },
            numbers: PixelNumbers::new(terms.seed, parameters.jitter, sample),
            rays: terms.budget,
            sample,
            bundle: parameters.bundle,
            unbiased,
        };
        rendered
            .stages
            .time("rendering", || gather.fill(&mut film, counter));
        rendered.stages.time("filtering", || {
            rendered.non_finite += filter::resolve(&film, parameters, terms.budget, &mut sums);
        });
    }
    rendered.image = Image {
        width: shot.width,
        height: shot.height,
        pixels: sums
            .into_iter()
            .map(|sum| (sum / shot.spp as f32).into())
            .collect(),
    };
    let set = std::mem::take(&mut lights.set);
    rendered.found.extend(set.found.iter().copied());
    rendered.lights = Some(set);
    rendered.bytes_cache = released((lights, arrays, irradiance));
    rendered
}
