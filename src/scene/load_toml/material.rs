//! `[texture.*]` and `[material.*]`.

use std::path::Path;

use image::ImageDecoder;
use toml::Spanned;
use toml::de::DeValue;

use super::Loader;
use super::keys::Keys;
use crate::scene::mesh_mtl::{MtlMap, MtlMaterial, coated, phong_alpha};
use crate::scene::text::advice;
use crate::scene::{
    Alpha, Bsdf, ColourSource, Material, MicrofacetDistribution, Roughness, SceneError,
    TextureDescription, Wrap,
};

/// `Kd` of a material that gives none.
const DEFAULT_DIFFUSE: f32 = 0.8;

impl Loader {
    pub(super) fn textures(&mut self, keys: &Keys) -> Result<(), SceneError> {
        let Some(value) = keys.get("texture") else {
            return Ok(());
        };
        for (name, value) in Keys::of(keys.source, value, "[texture]")?.entries() {
            let keys = Keys::of(keys.source, value, format!("[texture.{name}]"))?;
            let mut texture = TextureDescription::file(self.file(&keys)?);
            texture.srgb = keys.boolean("srgb", texture.srgb)?;
            texture.nearest = keys.word("filter", &[("bilinear", false), ("nearest", true)])?;
            texture.wrap = keys.word(
                "wrap",
                &[
                    ("repeat", Wrap::Repeat),
                    ("clamp", Wrap::Clamp),
                    ("mirror", Wrap::Mirror),
                ],
            )?;
            let pair =
                |p: Option<[f64; 2]>, default: f32| p.map_or([default; 2], |p| p.map(|x| x as f32));
            texture.uv_scale = pair(keys.numbers("uv_scale")?, 1.0);
            texture.uv_offset = pair(keys.numbers("uv_offset")?, 0.0);
            keys.finish()?;
            self.scene.textures.push(texture);
            self.texture_names.push(name.to_owned());
        }
        Ok(())
    }

    pub(super) fn materials(&mut self, keys: &Keys) -> Result<(), SceneError> {
        let Some(value) = keys.get("material") else {
            return Ok(());
        };
        for (name, value) in Keys::of(keys.source, value, "[material]")?.entries() {
            let mut keys = Keys::of(keys.source, value, format!("[material.{name}]"))?;
            let kind = keys.kind(&["diffuse", "plastic", "conductor", "dielectric"])?;
            keys.what = format!("[material.{name}] ({kind})");
            let bsdf = match kind {
                "plastic" => self.plastic(&keys)?,
                "conductor" => self.conductor(&keys)?,
                "dielectric" => dielectric(&keys)?,
                _ => Bsdf::Diffuse {
                    reflectance: self.colour_source(&keys, "reflectance", 0.5)?,
                },
            };
            let opacity = match keys.get("opacity") {
                Some(value) => Some(self.source_of(&keys, "opacity", value)?),
                None => None,
            };
            let two_sided = keys.boolean("two_sided", true)?;
            keys.finish()?;
            self.scene.materials.push(Material {
                name: name.to_owned(),
                bsdf,
                two_sided,
                back: None,
                blend: None,
                opacity,
                bump: None,
                normals: None,
                soft_terminators: false,
            });
        }
        Ok(())
    }

    /// The index of a material from a library.
    pub(super) fn mtl_material(&mut self, mtl: &MtlMaterial) -> usize {
        let mut source = |texture: Option<TextureDescription>, constant: [f32; 3]| match texture {
            None => ColourSource::Constant(constant),
            Some(texture) => {
                self.scene.textures.push(texture);
                ColourSource::Texture(self.scene.textures.len() - 1)
            }
        };
        let diffuse_map = mtl.diffuse_map.as_ref();
        let diffuse_map = diffuse_map.map(|map| TextureDescription {
            // As the specification has it; without `Kd` a map is shown as it is.
            factor: mtl.diffuse.unwrap_or([1.0; 3]).map(|d| d * map.gain),
            base: map.changes_values().then(|| {
                let diffuse = mtl.diffuse.unwrap_or([1.0; 3]);
                diffuse.map(|d| d * map.base)
            }),
            ..texture(map)
        });
        let colour = mtl.diffuse.unwrap_or([DEFAULT_DIFFUSE; 3]);
        let diffuse = source(diffuse_map, colour);
        let transparent = mtl.opacity < 1.0 || mtl.opacity_map.is_some();
        let opacity_map = mtl.opacity_map.as_ref();
        let opacity_map = opacity_map.map(|map| opacity_texture(map, mtl.opacity * map.gain));
        let opacity = transparent.then(|| source(opacity_map, [mtl.opacity; 3]));
        self.scene.materials.push(Material {
            bsdf: coated(diffuse, mtl.specular, phong_alpha(mtl.exponent)),
            opacity,
            ..Material::diffuse(&mtl.name, colour)
        });
        self.scene.materials.len() - 1
    }

    fn plastic(&self, keys: &Keys) -> Result<Bsdf, SceneError> {
        Ok(Bsdf::Plastic {
            diffuse: self.colour_source(keys, "diffuse", 0.5)?,
            specular: keys.share("specular")?.unwrap_or([1.0; 3]),
            ior: keys.positive("ior")?.unwrap_or(1.5) as f32,
            alpha: keys.non_negative("alpha")?.unwrap_or(0.1) as f32,
            distribution: distribution(keys)?,
            nonlinear: keys.boolean("nonlinear", false)?,
            lossless: keys.boolean("lossless", false)?,
        })
    }

    fn conductor(&self, keys: &Keys) -> Result<Bsdf, SceneError> {
        Ok(Bsdf::Conductor {
            eta: keys.colour("eta")?.unwrap_or([0.0; 3]),
            k: keys.colour("k")?.unwrap_or([0.0; 3]),
            specular: self.colour_source(keys, "specular", 1.0)?,
            alpha: keys.non_negative("alpha")?.unwrap_or(0.1) as f32,
            distribution: distribution(keys)?,
        })
    }

    fn colour_source(
        &self,
        keys: &Keys,
        key: &'static str,
        default: f32,
    ) -> Result<ColourSource, SceneError> {
        match keys.get(key) {
            Some(value) => self.source_of(keys, key, value),
            None => Ok(ColourSource::Constant([default; 3])),
        }
    }

    /// A colour, or `{ texture = "name" }`.
    fn source_of(
        &self,
        keys: &Keys,
        key: &str,
        value: &Spanned<DeValue>,
    ) -> Result<ColourSource, SceneError> {
        if !value.get_ref().is_table() {
            return keys.share_of(key, value).map(ColourSource::Constant);
        }
        let inner = Keys::of(keys.source, value, format!("`{key}` of {}", keys.what))?;
        let name = inner.required("texture", inner.string("texture")?)?;
        inner.finish()?;
        match self.texture_names.iter().position(|n| n == name) {
            Some(index) => Ok(ColourSource::Texture(index)),
            None => {
                let known: Vec<&str> = self.texture_names.iter().map(String::as_str).collect();
                Err(inner.error(format!(
                    "no texture is called `{name}`; {}",
                    advice(name, &known)
                )))
            }
        }
    }
}

/// The picture of a library.
fn texture(map: &MtlMap) -> TextureDescription {
    let mut texture = TextureDescription::file(map.file.clone());
    texture.uv_scale = map.scale;
    texture.uv_offset = map.offset;
    if map.clamp {
        texture.wrap = Wrap::Clamp;
    }
    texture
}

/// The alpha channel of a picture that has one, else its values as they are stored, times a factor.
fn opacity_texture(map: &MtlMap, factor: f32) -> TextureDescription {
    let mut texture = texture(map);
    texture.srgb = false;
    texture.factor = [factor; 3];
    if has_alpha(&map.file) {
        texture.alpha = Some(Alpha {
            factor,
            cutoff: None,
        });
    }
    texture
}

/// Whether a file is a picture with an alpha channel.
fn has_alpha(path: &Path) -> bool {
    let is_file = crate::files::check_ends(path).is_ok();
    let reader = is_file
        .then(|| image::ImageReader::open(path).ok())
        .flatten();
    let decoder = reader.and_then(|r| r.with_guessed_format().ok()?.into_decoder().ok());
    decoder.is_some_and(|decoder| decoder.color_type().has_alpha())
}

fn distribution(keys: &Keys) -> Result<MicrofacetDistribution, SceneError> {
    use MicrofacetDistribution::{Beckmann, Ggx};
    keys.word("distribution", &[("ggx", Ggx), ("beckmann", Beckmann)])
}

fn dielectric(keys: &Keys) -> Result<Bsdf, SceneError> {
    let thin = keys.boolean("thin", false)?;
    let alpha = keys.non_negative("alpha")?.unwrap_or(0.0) as f32;
    let distribution = distribution(keys)?;
    let is_rough = alpha > 0.0;
    if thin && is_rough {
        return Err(keys.error("a thin dielectric is clear: `alpha` must be 0"));
    }
    Ok(Bsdf::Dielectric {
        ior: keys.positive("ior")?.unwrap_or(1.5) as f32,
        thin,
        roughness: is_rough.then_some(Roughness {
            alpha,
            distribution,
        }),
        reflectance: keys.share("reflectance")?.unwrap_or([1.0; 3]),
        transmittance: keys.share("transmittance")?.unwrap_or([1.0; 3]),
    })
}
