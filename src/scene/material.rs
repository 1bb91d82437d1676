//! Materials as declared; [`crate::shade`] evaluates and samples them.

/// A colour that may come from a texture.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub enum ColourSource {
    /// The same everywhere, linear RGB.
    Constant([f32; 3]),
    /// Index into the scene's textures.
    Texture(usize),
    /// The colours of the vertices, interpolated; grey 0.5 where a mesh has none.
    Vertices,
}

/// Two materials of which a ray meets one, by chance (Mitsuba's `blendbsdf`).
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Blend {
    /// Indices of both.
    pub materials: [usize; 2],
    /// The chance of the second.
    pub second: ColourSource,
}

/// A surface material.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// What shapes call it.
    pub name: String,
    /// How it scatters light.
    pub bsdf: Bsdf,
    /// Reflects alike on both sides; a one-sided opaque material is black from behind.
    pub two_sided: bool,
    /// Index of the material that is seen from behind, if that is another one.
    pub back: Option<usize>,
    /// What stands in its place by chance; what else is said of it here is that of one of them.
    pub blend: Option<Blend>,
    /// Probability that a ray meets the surface (Mitsuba's `mask`); `None` is opaque.
    pub opacity: Option<ColourSource>,
    /// Bump map: texture index and displacement scale in scene units per texture value.
    pub bump: Option<(usize, f32)>,
    /// Normal map: texture whose colours, doubled and less 1, are normals along u, across it and out of the surface.
    pub normals: Option<usize>,
    /// Whether light is weakened the more it grazes the surface and the more the bump or normal map bends the normal, so
    /// that shadows do not end abruptly (Estevez et al. 2019; Mitsuba's `use_shadowing_function`).
    pub soft_terminators: bool,
}

/// How the normals of microfacets spread (Walter et al. 2007).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub enum MicrofacetDistribution {
    /// Trowbridge and Reitz: long tails.
    #[default]
    Ggx,
    /// Gaussian slopes.
    Beckmann,
}

/// How rough a boundary is.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Roughness {
    /// Parameter of the distribution, above 0.
    pub alpha: f32,
    /// Of its microfacets.
    pub distribution: MicrofacetDistribution,
}

/// Scattering models. `alpha` is the roughness parameter of the distribution (not its square root).
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub enum Bsdf {
    /// Lambertian reflection.
    Diffuse {
        /// Albedo, linear RGB.
        reflectance: ColourSource,
    },
    /// A diffuse base under a dielectric coating; `alpha = 0` is the smooth plastic.
    Plastic {
        /// Albedo of the base, linear RGB.
        diffuse: ColourSource,
        /// Factor on the reflection of the coating, linear RGB; 1 is physical.
        specular: [f32; 3],
        /// Index of refraction of the coating over that of the air.
        ior: f32,
        /// Roughness of the coating.
        alpha: f32,
        /// Of the coating's microfacets.
        distribution: MicrofacetDistribution,
        /// Colour shift by internal scattering (Mitsuba's `nonlinear`).
        nonlinear: bool,
        /// Whether the base gets all light that a rough coating does not reflect. Mitsuba's `roughplastic` loses what
        /// passes from facet to facet, up to three quarters of it at `alpha = 1`; models of other formats do not.
        lossless: bool,
    },
    /// `alpha = 0` is the perfect mirror. Complex index of refraction per channel; `eta = 0` with
    /// `k = 0` stands for Fresnel reflectance 1.
    Conductor {
        /// Real part of the index of refraction, per channel.
        eta: [f32; 3],
        /// Imaginary part of the index of refraction, per channel.
        k: [f32; 3],
        /// Factor on the reflection; 1 is physical.
        specular: ColourSource,
        /// Roughness.
        alpha: f32,
        /// Of its microfacets.
        distribution: MicrofacetDistribution,
    },
    /// Glass, clear or frosted; `ior` = interior over exterior. `thin` neglects refraction.
    Dielectric {
        /// Interior over exterior index of refraction.
        ior: f32,
        /// Whether it is a pane that light passes undeviated, with the reflections inside it.
        thin: bool,
        /// Factor on what is reflected, linear RGB; 1 is physical.
        reflectance: [f32; 3],
        /// Factor on what is transmitted, linear RGB; 1 is physical.
        transmittance: [f32; 3],
        /// `None` is clear; panes are.
        #[serde(skip_serializing_if = "Option::is_none")]
        roughness: Option<Roughness>,
    },
}

impl Bsdf {
    /// Whether what is seen lies behind the surface or in it: mirrors and all glass, frosted too.
    pub fn is_delta(&self) -> bool {
        match self {
            Self::Conductor { alpha, .. } => *alpha <= 0.0,
            Self::Dielectric { .. } => true,
            Self::Diffuse { .. } | Self::Plastic { .. } => false,
        }
    }
}

impl Material {
    /// An opaque two-sided diffuse material.
    pub fn diffuse(name: &str, reflectance: [f32; 3]) -> Self {
        Self {
            name: name.to_owned(),
            bsdf: Bsdf::Diffuse {
                reflectance: ColourSource::Constant(reflectance),
            },
            two_sided: true,
            back: None,
            blend: None,
            opacity: None,
            bump: None,
            normals: None,
            soft_terminators: false,
        }
    }

    /// Whether light can pass or be mirrored without being scattered, so that what the camera sees
    /// lies behind this surface.
    pub fn is_specular(&self) -> bool {
        self.bsdf.is_delta() || self.opacity.is_some()
    }

    /// Whether it is rough glass.
    pub(super) fn is_frosted(&self) -> bool {
        let roughness = match self.bsdf {
            Bsdf::Dielectric { roughness, .. } => roughness,
            _ => None,
        };
        roughness.is_some()
    }

    /// The colours that may come from textures or vertices.
    fn colours(&self) -> impl Iterator<Item = ColourSource> {
        let colour = match &self.bsdf {
            Bsdf::Diffuse { reflectance } => Some(reflectance),
            Bsdf::Plastic { diffuse, .. } => Some(diffuse),
            Bsdf::Conductor { specular, .. } => Some(specular),
            Bsdf::Dielectric { .. } => None,
        };
        let share = self.blend.map(|blend| blend.second);
        [colour.copied(), self.opacity, share].into_iter().flatten()
    }

    /// Indices of the materials that it refers to.
    pub(super) fn others(&self) -> impl Iterator<Item = usize> + use<> {
        let blended = self.blend.map(|blend| blend.materials);
        self.back.into_iter().chain(blended.into_iter().flatten())
    }

    /// Indices of the textures that it refers to.
    pub fn textures(&self) -> Vec<usize> {
        let bump = self.bump.map(|(i, _)| i);
        let colours = self.colour_textures();
        colours.chain(bump).chain(self.normals).collect()
    }

    /// Indices of the textures that give its colours.
    pub(super) fn colour_textures(&self) -> impl Iterator<Item = usize> {
        self.colours().filter_map(|source| match source {
            ColourSource::Texture(i) => Some(i),
            ColourSource::Constant(_) | ColourSource::Vertices => None,
        })
    }

    /// Whether it takes the colours of vertices.
    pub(super) fn has_vertex_colours(&self) -> bool {
        self.colours()
            .any(|source| source == ColourSource::Vertices)
    }
}
