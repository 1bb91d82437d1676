//! Surfaces that shine.

use std::collections::BTreeSet;

use ::gltf::json::material::Material as Declared;
use ::gltf::json::texture::Info;
use rayon::prelude::*;

use super::Importer;
use super::image::Means;
use super::texture::Use;
use crate::scene::SceneError;

/// What a material says of its own light.
pub(super) struct Emission<'a> {
    factor: [f32; 3],
    strength: f32,
    texture: Option<&'a Info>,
    both_sides: bool,
}

impl<'a> Emission<'a> {
    pub fn of(declared: &'a Declared) -> Self {
        let extensions = declared.extensions.as_ref();
        let strength = extensions.and_then(|e| e.emissive_strength.as_ref());
        Self {
            factor: declared.emissive_factor.0,
            strength: strength.map_or(1.0, |s| s.emissive_strength.0),
            texture: declared.emissive_texture.as_ref(),
            both_sides: declared.double_sided,
        }
    }
}

impl Importer<'_> {
    /// Computes the means that materials may need, all at once; what fails is told where it is used.
    pub(super) fn prepare_means(&self) {
        let root = self.file.root();
        let infos = root.materials.iter().flat_map(|material| {
            let extensions = material.extensions.as_ref();
            let transmission = extensions.and_then(|e| e.transmission.as_ref());
            let glossy = extensions.and_then(|e| e.pbr_specular_glossiness.as_ref());
            let shines = material.emissive_factor.0 != [0.0; 3];
            [
                material
                    .pbr_metallic_roughness
                    .metallic_roughness_texture
                    .as_ref(),
                material.emissive_texture.as_ref().filter(|_| shines),
                transmission.and_then(|t| t.transmission_texture.as_ref()),
                glossy.and_then(|g| g.specular_glossiness_texture.as_ref()),
            ]
        });
        let textures = infos
            .flatten()
            .filter_map(|info| root.textures.get(info.index.value()));
        let images: BTreeSet<usize> = textures.map(|texture| texture.source.value()).collect();
        let images: Vec<usize> = images
            .into_iter()
            .filter(|i| *i < root.images.len())
            .collect();
        images
            .par_iter()
            .for_each(|image| _ = self.file.image_means(*image));
    }

    /// Emitted radiance: factor times strength times the mean of the texture. Candela per square metre become
    /// W/(m² sr), number for number.
    pub(super) fn emission(
        &mut self,
        emission: &Emission,
        place: &str,
    ) -> Result<Option<[f32; 3]>, SceneError> {
        let radiance = emission.factor.map(|f| f * emission.strength);
        if !radiance.iter().all(|r| r.is_finite() && *r >= 0.0) {
            let message = "its emission must be finite and not below 0";
            return Err(self.file.error(place, message));
        }
        if radiance == [0.0; 3] {
            return Ok(None);
        }
        let means = match emission.texture {
            Some(info) => self.means(info)?,
            None => None,
        };
        if means.is_some() {
            self.note("an emissiveTexture becomes its mean: a shape shines evenly");
        }
        let mean = means.map_or([1.0; 3], |m| m.decoded);
        let radiance: [f32; 3] = std::array::from_fn(|c| radiance[c] * mean[c]);
        if radiance == [0.0; 3] {
            return Ok(None);
        }
        if emission.both_sides {
            self.note("a double-sided surface shines from its front only");
        }
        Ok(Some(radiance))
    }

    /// Means of the image of a texture, if it is there.
    pub(super) fn means(&mut self, info: &Info) -> Result<Option<Means>, SceneError> {
        let Some(image) = self.image_used(Use::of(info))? else {
            return Ok(None);
        };
        let means = self.file.image_means(image)?;
        if means.is_none() {
            self.note(format!("image {image} is absent: its texture counts as 1"));
        }
        Ok(means)
    }
}
