//! Materials: metallic-roughness and its extensions on plastic, conductor and glass.

use ::gltf::json::material::{AlphaMode, Material as Declared};
use ::gltf::json::texture::Info;

use super::Importer;
use super::document::{named, valid};
use super::emission::Emission;
use super::texture::{Part, Use};
use crate::scene::{Alpha, Bsdf, ColourSource, Material, MicrofacetDistribution, SceneError};

/// Below it a surface is as good as smooth, and the formulas of rough ones lose their digits.
const MIN_ALPHA: f32 = 1e-3;

/// What a primitive gets of its material.
#[derive(Clone, Copy)]
pub(super) struct Mapped {
    /// Index into the materials of the scene.
    pub material: usize,
    pub emission: Option<[f32; 3]>,
    /// The set of texture coordinates that its textures read.
    pub uv_set: u32,
}

impl Importer<'_> {
    /// The material of a primitive, mapped once; `None` is glTF's default material.
    pub(super) fn material(&mut self, index: Option<usize>) -> Result<Mapped, SceneError> {
        if let Some(mapped) = self.materials.get(&index) {
            return Ok(*mapped);
        }
        let file = self.file;
        let default = Declared::default();
        let declared = match index {
            None => &default,
            Some(i) => (file.root().materials.get(i))
                .ok_or_else(|| file.error(format!("material {i}"), "is not there"))?,
        };
        let name = declared.name.clone().filter(|n| !n.is_empty());
        let name = name.or_else(|| index.map(|i| format!("material {i}")));
        let place = index.map_or("the default material".into(), |i| {
            named("material", i, declared.name.as_deref())
        });
        let surface = Surface {
            declared,
            place: &place,
        };
        let mapped = Mapped {
            material: self.scene.materials.len(),
            emission: self.emission(&Emission::of(declared), &place)?,
            uv_set: surface.uv_set(),
        };
        let material = Material {
            name: name.unwrap_or("default".into()),
            bsdf: self.bsdf(&surface)?,
            back: None,
            blend: None,
            two_sided: declared.double_sided,
            opacity: self.opacity(&surface)?,
            bump: None,
            normals: None,
            soft_terminators: false,
        };
        self.note_dropped(declared);
        if mapped.emission.is_some() && material.opacity.is_some() {
            self.note("a surface that alpha leaves open shines as if it were not");
        }
        self.scene.materials.push(material);
        self.materials.insert(index, mapped);
        Ok(mapped)
    }

    fn bsdf(&mut self, surface: &Surface) -> Result<Bsdf, SceneError> {
        let extensions = surface.declared.extensions.as_ref();
        if let Some(glossy) = extensions.and_then(|e| e.pbr_specular_glossiness.as_ref()) {
            return self.specular_glossiness(surface, glossy);
        }
        let base = self.base_colour(surface)?;
        if extensions.is_some_and(|e| e.unlit.is_some()) {
            self.note("KHR_materials_unlit becomes a diffuse surface of its colour");
            return Ok(Bsdf::Diffuse { reflectance: base });
        }
        let [metallic, roughness] = self.metallic_roughness(surface)?;
        if let Some(glass) = self.glass(surface, roughness)? {
            return Ok(glass);
        }
        if metallic >= 0.5 {
            self.note("metal becomes a conductor that reflects the base colour at every angle");
            return Ok(Bsdf::Conductor {
                eta: [0.0; 3],
                k: [0.0; 3],
                specular: base,
                alpha: alpha_of(roughness),
                distribution: MicrofacetDistribution::Ggx,
            });
        }
        self.note(
            "what is not metal becomes plastic: a rough coating over a diffuse base of the base colour, which gets all \
             light that the coating does not reflect (in glTF what each facet does not)",
        );
        let ior = self.ior(surface)?;
        Ok(plastic(base, surface.specular(), ior, alpha_of(roughness)))
    }

    /// Base colour: a factor, a texture, or both.
    fn base_colour(&mut self, surface: &Surface) -> Result<ColourSource, SceneError> {
        let pbr = &surface.declared.pbr_metallic_roughness;
        let [r, g, b, _] = self.within_unit(surface, "baseColorFactor", pbr.base_color_factor.0)?;
        self.coloured(pbr.base_color_texture.as_ref(), [r, g, b])
    }

    pub(super) fn coloured(
        &mut self,
        info: Option<&Info>,
        factor: [f32; 3],
    ) -> Result<ColourSource, SceneError> {
        let texture = match info {
            Some(info) => self.texture(Use::of(info), Part::Colour(factor))?,
            None => None,
        };
        Ok(texture.map_or(ColourSource::Constant(factor), ColourSource::Texture))
    }

    /// Metallic and roughness, each its factor times the mean of its texture.
    fn metallic_roughness(&mut self, surface: &Surface) -> Result<[f32; 2], SceneError> {
        let pbr = &surface.declared.pbr_metallic_roughness;
        let factors = [pbr.metallic_factor.0, pbr.roughness_factor.0];
        let [metallic, roughness] =
            self.within_unit(surface, "metallicFactor or roughnessFactor", factors)?;
        let means = match &pbr.metallic_roughness_texture {
            Some(info) => self.means(info)?,
            None => None,
        };
        let [_, green, blue] = means.map_or([1.0; 3], |m| m.raw);
        if means.is_some() {
            self.note("a metallicRoughnessTexture becomes its mean: metallic and roughness do not vary over a surface");
        }
        let metallic = metallic * blue;
        if metallic > 0.05 && metallic < 0.95 {
            self.note("what is metal in part becomes what it is for the greater part");
        }
        Ok([metallic, roughness * green])
    }

    /// Alpha as the probability that a ray meets the surface.
    fn opacity(&mut self, surface: &Surface) -> Result<Option<ColourSource>, SceneError> {
        let declared = surface.declared;
        let written = declared.alpha_cutoff.unwrap_or_default().0;
        if !(0.0..=f32::MAX).contains(&written) {
            let message = format!("alphaCutoff {written} is not a number of at least 0");
            return Err(self.file.error(surface.place, message));
        }
        let cutoff = match valid(&declared.alpha_mode) {
            Some(AlphaMode::Mask) => Some(written),
            Some(AlphaMode::Blend) => None,
            _ => return Ok(None),
        };
        let (factor, info) = surface.alpha();
        let [factor] = self.within_unit(surface, "the alpha factor", [factor])?;
        if cutoff.is_none() {
            self.note("alphaMode BLEND becomes a chance to be met: no order of drawing is needed");
        }
        let alpha = Alpha { factor, cutoff };
        if let Some(info) = info
            && let Some(image) = self.image_used(Use::of(info))?
            && self.file.image_has_alpha(image)? == Some(true)
        {
            let texture = self.texture(Use::of(info), Part::Alpha(alpha))?;
            return Ok(texture.map(ColourSource::Texture));
        }
        let constant = alpha.of(1.0);
        Ok((constant < 1.0).then_some(ColourSource::Constant([constant; 3])))
    }

    fn note_dropped(&mut self, declared: &Declared) {
        if declared.normal_texture.is_some() {
            self.note("a normal map is left out");
        }
        if declared.occlusion_texture.is_some() {
            self.note("an occlusion map is left out: occlusion is computed");
        }
        if let Some(extensions) = &declared.extensions {
            for name in extensions.others.keys() {
                self.note(format!("{name} is left out"));
            }
            let specular = extensions.specular.as_ref();
            if specular
                .is_some_and(|s| s.specular_texture.is_some() || s.specular_color_texture.is_some())
            {
                self.note("the textures of KHR_materials_specular are left out");
            }
        }
    }

    /// Values that glTF wants between 0 and 1.
    pub(super) fn within_unit<const N: usize>(
        &self,
        surface: &Surface,
        what: &str,
        values: [f32; N],
    ) -> Result<[f32; N], SceneError> {
        let rounded = values.map(|v| if v > 1.0 && v < 1.00001 { 1.0 } else { v });
        match rounded.iter().all(|v| (0.0..=1.0).contains(v)) {
            true => Ok(rounded),
            false => {
                let message = format!("{what} {values:?} is not between 0 and 1");
                Err(self.file.error(surface.place, message))
            }
        }
    }
}

/// A material of the file, and how messages call it.
pub(super) struct Surface<'a> {
    pub declared: &'a Declared,
    pub place: &'a str,
}

impl Surface<'_> {
    /// The factor and the texture whose alpha counts.
    fn alpha(&self) -> (f32, Option<&Info>) {
        alpha_of_colour(self.declared)
    }

    /// The set of texture coordinates of the colour: the only texture that is looked up.
    fn uv_set(&self) -> u32 {
        self.alpha().1.map_or(0, |info| Use::of(info).uv_set())
    }

    /// Factor on what the coating reflects.
    fn specular(&self) -> [f32; 3] {
        let declared = self
            .declared
            .extensions
            .as_ref()
            .and_then(|e| e.specular.as_ref());
        declared.map_or([1.0; 3], |s| {
            s.specular_color_factor
                .0
                .map(|c| (c * s.specular_factor.0).clamp(0.0, 1.0))
        })
    }
}

/// Whether a texture gives a material its colour.
pub(super) fn has_colour_texture(declared: &Declared) -> bool {
    alpha_of_colour(declared).1.is_some()
}

/// The alpha factor of a material's colour, and the texture of that.
fn alpha_of_colour(declared: &Declared) -> (f32, Option<&Info>) {
    let glossy = declared.extensions.as_ref();
    let pbr = &declared.pbr_metallic_roughness;
    match glossy.and_then(|e| e.pbr_specular_glossiness.as_ref()) {
        Some(glossy) => (glossy.diffuse_factor.0[3], glossy.diffuse_texture.as_ref()),
        None => (pbr.base_color_factor.0[3], pbr.base_color_texture.as_ref()),
    }
}

pub(super) fn plastic(diffuse: ColourSource, specular: [f32; 3], ior: f32, alpha: f32) -> Bsdf {
    if ior < 1.001 || specular == [0.0; 3] {
        return Bsdf::Diffuse {
            reflectance: diffuse,
        };
    }
    Bsdf::Plastic {
        diffuse,
        specular,
        ior,
        alpha,
        distribution: MicrofacetDistribution::Ggx,
        nonlinear: false,
        lossless: true,
    }
}

/// glTF's roughness is the square root of the width of the distribution.
pub(super) fn alpha_of(roughness: f32) -> f32 {
    let alpha = roughness * roughness;
    if alpha < MIN_ALPHA { 0.0 } else { alpha }
}
