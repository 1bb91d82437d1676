//! Textures: an image, how it is filtered and wrapped, and where it lies on the surface.

use ::gltf::json::extensions::texture::TextureTransform;
use ::gltf::json::texture::{Info, MagFilter, MinFilter, WrappingMode};

use super::Importer;
use super::document::{named, valid};
use crate::scene::{Alpha, SceneError, TextureDescription, TextureSource, Wrap};

/// A use of a texture by a material.
#[derive(Clone, Copy)]
pub(super) struct Use<'a> {
    texture: usize,
    set: u32,
    transform: Option<&'a TextureTransform>,
}

impl<'a> Use<'a> {
    pub fn of(info: &'a Info) -> Self {
        let extensions = info.extensions.as_ref();
        let transform = extensions.and_then(|e| e.texture_transform.as_ref());
        Self {
            texture: info.index.value(),
            set: transform
                .and_then(|t| t.tex_coord)
                .unwrap_or(info.tex_coord),
            transform,
        }
    }

    /// Which set of texture coordinates it reads.
    pub fn uv_set(&self) -> u32 {
        self.set
    }
}

/// What is taken of the texels.
pub(super) enum Part {
    /// Their colour, times a factor.
    Colour([f32; 3]),
    Alpha(Alpha),
}

impl Importer<'_> {
    /// The image of a texture, if it has one that can be read.
    pub(super) fn image_of(&mut self, texture: usize) -> Result<Option<usize>, SceneError> {
        let root = self.file.root();
        let Some(declared) = root.textures.get(texture) else {
            return Err(self
                .file
                .error(format!("texture {texture}"), "is not there"));
        };
        let image = declared.source.value();
        if image < root.images.len() {
            return Ok(Some(image));
        }
        let place = named("texture", texture, declared.name.as_deref());
        self.note(format!(
            "{place} has no image in a format that can be read and is left out"
        ));
        Ok(None)
    }

    /// As [`Self::image_of`], of a use.
    pub(super) fn image_used(&mut self, used: Use) -> Result<Option<usize>, SceneError> {
        self.image_of(used.texture)
    }

    /// The index of a described texture, if it has an image.
    pub(super) fn texture(&mut self, used: Use, part: Part) -> Result<Option<usize>, SceneError> {
        let Some(image) = self.image_of(used.texture)? else {
            return Ok(None);
        };
        // Damage is told before anything is rendered.
        self.file.image_has_alpha(image)?;
        let source = self.file.image_source(image)?;
        let mut described = self.sampled(used.texture, source)?;
        if let Some(transform) = used.transform {
            self.place(transform, &mut described)?;
        }
        match part {
            Part::Colour(factor) => described.factor = factor,
            Part::Alpha(alpha) => {
                described.srgb = false;
                described.alpha = Some(alpha);
            }
        }
        let textures = &mut self.scene.textures;
        let known = textures.iter().position(|t| *t == described);
        Ok(Some(known.unwrap_or_else(|| {
            textures.push(described);
            textures.len() - 1
        })))
    }

    /// A texture as its sampler says.
    fn sampled(
        &mut self,
        texture: usize,
        source: TextureSource,
    ) -> Result<TextureDescription, SceneError> {
        let mut described = TextureDescription {
            source,
            ..TextureDescription::file("".into())
        };
        let root = self.file.root();
        let Some(sampler) = root.textures[texture].sampler else {
            return Ok(described);
        };
        let Some(sampler) = root.samplers.get(sampler.value()) else {
            return Err(self
                .file
                .error(format!("sampler {}", sampler.value()), "is not there"));
        };
        let magnified = sampler.mag_filter.as_ref().and_then(valid);
        let reduced = sampler.min_filter.as_ref().and_then(valid);
        described.nearest = match (magnified, reduced) {
            (Some(filter), _) => filter == MagFilter::Nearest,
            (None, Some(filter)) => filter == MinFilter::Nearest,
            (None, None) => false,
        };
        let modes = [&sampler.wrap_s, &sampler.wrap_t].map(|mode| match valid(mode) {
            Some(WrappingMode::ClampToEdge) => Wrap::Clamp,
            Some(WrappingMode::MirroredRepeat) => Wrap::Mirror,
            Some(WrappingMode::Repeat) | None => Wrap::Repeat,
        });
        if modes[0] != modes[1] {
            self.note("wrapping that differs along s and t becomes that along s");
        }
        described.wrap = modes[0];
        Ok(described)
    }

    /// Scale, turn and offset of the texture coordinates, from glTF's v (downwards) to ours (upwards).
    ///
    /// `KHR_texture_transform` has u' = c sᵤ u + s sᵥ v + oᵤ and v' = −s sᵤ u + c sᵥ v + oᵥ. With w = 1 − v that
    /// is u' = c sᵤ u − s sᵥ w + (oᵤ + s sᵥ) and w' = s sᵤ u + c sᵥ w + (1 − oᵥ − c sᵥ): the same turn.
    fn place(
        &mut self,
        transform: &TextureTransform,
        described: &mut TextureDescription,
    ) -> Result<(), SceneError> {
        let (scale, offset) = (transform.scale.0, transform.offset.0);
        let turn_rad = transform.rotation.0;
        let all = [scale[0], scale[1], offset[0], offset[1], turn_rad];
        if !all.iter().all(|value| value.is_finite()) {
            return Err(self
                .file
                .error("KHR_texture_transform", "its values are not finite"));
        }
        let (sine, cosine) = turn_rad.sin_cos();
        described.uv_scale = scale;
        described.uv_turn_rad = turn_rad;
        described.uv_offset = [
            offset[0] + sine * scale[1],
            1.0 - offset[1] - cosine * scale[1],
        ];
        Ok(())
    }
}
