//! The older model of surfaces: `KHR_materials_pbrSpecularGlossiness`.

use ::gltf::json::extensions::material::PbrSpecularGlossiness;

use super::Importer;
use super::material::{Surface, alpha_of, plastic};
use crate::scene::{Bsdf, ColourSource, MicrofacetDistribution, SceneError};

impl Importer<'_> {
    /// A diffuse and a specular colour: plastic, or a conductor where the specular one is stronger.
    pub(super) fn specular_glossiness(
        &mut self,
        surface: &Surface,
        glossy: &PbrSpecularGlossiness,
    ) -> Result<Bsdf, SceneError> {
        let [r, g, b, _] = self.within_unit(surface, "diffuseFactor", glossy.diffuse_factor.0)?;
        let specular = self.within_unit(surface, "specularFactor", glossy.specular_factor.0)?;
        let [glossiness] =
            self.within_unit(surface, "glossinessFactor", [glossy.glossiness_factor.0])?;
        let means = match &glossy.specular_glossiness_texture {
            Some(info) => self.means(info)?,
            None => None,
        };
        if means.is_some() {
            self.note("a specularGlossinessTexture becomes its mean colour, and its glossiness 1");
        }
        let mean = means.map_or([1.0; 3], |m| m.decoded);
        let specular: [f32; 3] = std::array::from_fn(|c| specular[c] * mean[c]);
        let alpha = alpha_of(1.0 - glossiness);
        let strongest = specular.iter().copied().fold(0.0, f32::max);
        if strongest > r.max(g).max(b) {
            self.note(
                "KHR_materials_pbrSpecularGlossiness becomes a conductor of the specular colour where that \
                 outshines the diffuse one",
            );
            return Ok(Bsdf::Conductor {
                eta: [0.0; 3],
                k: [0.0; 3],
                specular: ColourSource::Constant(specular),
                alpha,
                distribution: MicrofacetDistribution::Ggx,
            });
        }
        self.note("KHR_materials_pbrSpecularGlossiness becomes plastic that reflects the specular colour head on");
        // A coating of that reflectance for the strongest channel, tinted for the others.
        let root = strongest.sqrt().clamp(0.01, 0.9);
        let ior = (1.0 + root) / (1.0 - root);
        let tint = specular.map(|s| (s / (root * root)).min(1.0));
        let diffuse = self.coloured(glossy.diffuse_texture.as_ref(), [r, g, b])?;
        Ok(plastic(diffuse, tint, ior, alpha))
    }
}
