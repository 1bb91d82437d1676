//! Light through surfaces: `KHR_materials_transmission`, `_ior` and `_volume`.

use super::Importer;
use super::material::{Surface, alpha_of};
use crate::scene::{Bsdf, MicrofacetDistribution, Roughness, SceneError};

/// Index of refraction where none is given.
const IOR: f32 = 1.5;

impl Importer<'_> {
    /// Glass, if most of the light that enters goes through.
    pub(super) fn glass(
        &mut self,
        surface: &Surface,
        roughness: f32,
    ) -> Result<Option<Bsdf>, SceneError> {
        let extensions = surface.declared.extensions.as_ref();
        let Some(transmission) = extensions.and_then(|e| e.transmission.as_ref()) else {
            return Ok(None);
        };
        let mean = match &transmission.transmission_texture {
            Some(info) => self.means(info)?.map_or(1.0, |m| m.raw[0]),
            None => 1.0,
        };
        if transmission.transmission_factor.0 * mean < 0.5 {
            self.note("KHR_materials_transmission of less than a half is left out");
            return Ok(None);
        }
        self.note("KHR_materials_transmission becomes glass of the mean base colour");
        let volume = extensions.and_then(|e| e.volume.as_ref());
        let thick = volume.is_some_and(|v| v.thickness_factor.0 > 0.0);
        let alpha = alpha_of(roughness);
        if alpha > 0.0 && !thick {
            self.note("rough panes of glass become smooth");
        }
        if volume.is_some_and(|v| v.attenuation_distance.0.is_finite()) {
            self.note("the attenuation of KHR_materials_volume is left out");
        }
        Ok(Some(Bsdf::Dielectric {
            ior: self.ior(surface)?.max(1.0),
            thin: !thick,
            reflectance: [1.0; 3],
            transmittance: self.mean_base_colour(surface)?,
            roughness: (alpha > 0.0 && thick).then_some(Roughness {
                alpha,
                distribution: MicrofacetDistribution::Ggx,
            }),
        }))
    }

    fn mean_base_colour(&mut self, surface: &Surface) -> Result<[f32; 3], SceneError> {
        let pbr = &surface.declared.pbr_metallic_roughness;
        let factor = pbr.base_color_factor.0;
        let means = match &pbr.base_color_texture {
            Some(info) => self.means(info)?,
            None => None,
        };
        let mean = means.map_or([1.0; 3], |m| m.decoded);
        Ok(std::array::from_fn(|c| factor[c] * mean[c]))
    }

    /// Index of refraction.
    pub(super) fn ior(&mut self, surface: &Surface) -> Result<f32, SceneError> {
        let declared = surface
            .declared
            .extensions
            .as_ref()
            .and_then(|e| e.ior.as_ref());
        match declared.map(|d| d.ior.0) {
            None => Ok(IOR),
            Some(ior) if ior >= 1.0 && ior.is_finite() => Ok(ior),
            // A mirror, says the extension.
            Some(0.0) => {
                self.note("KHR_materials_ior of 0 becomes 1.5");
                Ok(IOR)
            }
            Some(_) => Err(self
                .file
                .error(surface.place, "its index of refraction is below 1")),
        }
    }
}
