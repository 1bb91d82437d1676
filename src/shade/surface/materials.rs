//! The materials of a scene, and what one of them scatters at a place of a triangle.

use std::sync::Arc;

use glam::{Vec2, Vec3};

use crate::image::luminance;
use crate::scene::{Bsdf, ColourSource, Material, Scene};
use crate::shade::bsdf::{
    Coating, Conductor, Dielectric, Diffuse, LocalBsdf, Microfacets, Model, Plastic,
};

/// Materials with what is integrated once: the coatings of the plastics.
pub struct Surfaces<'a> {
    pub(super) scene: &'a Scene,
    /// Of each material that has one.
    coatings: Vec<Option<Arc<Coating>>>,
    has_masks: bool,
}

/// Where on a triangle colours are looked up.
pub(super) struct Place {
    pub uv: Vec2,
    /// Vertices of the triangle.
    pub corners: [usize; 3],
    /// Barycentric, of the corners.
    pub weights: [f32; 3],
}

impl<'a> Surfaces<'a> {
    /// Integrates the coatings of the scene's plastics.
    pub fn new(scene: &'a Scene) -> Self {
        let coating_of = |material: &Material| match material.bsdf {
            Bsdf::Plastic {
                ior,
                alpha,
                distribution,
                lossless,
                ..
            } => Some(match lossless {
                true => Coating::lossless_of(distribution, alpha, ior),
                false => Coating::of(distribution, alpha, ior),
            }),
            _ => None,
        };
        Self {
            scene,
            coatings: scene.materials.iter().map(coating_of).collect(),
            has_masks: scene.materials.iter().any(|m| m.opacity.is_some()),
        }
    }

    /// Whether rays may pass anything by its opacity.
    pub fn has_masks(&self) -> bool {
        self.has_masks
    }

    /// A number in [0, 1]: the luminance of a colour.
    pub(super) fn share(&self, source: ColourSource, place: &Place) -> f32 {
        luminance(self.colour(source, place).into()).clamp(0.0, 1.0)
    }

    fn colour(&self, source: ColourSource, place: &Place) -> Vec3 {
        match source {
            ColourSource::Constant(rgb) => rgb.into(),
            ColourSource::Texture(index) => self
                .scene
                .textures
                .get(index)
                .map_or(Vec3::splat(0.5), |t| t.lookup(place.uv).into()),
            ColourSource::Vertices => {
                let corner = |k: usize| {
                    let colour = self.scene.colours.get(place.corners[k]);
                    place.weights[k] * colour.map_or(Vec3::splat(0.5), |c| Vec3::from(*c))
                };
                (0..3).map(corner).sum()
            }
        }
    }

    /// Scattering of a material, which has this index, at a place.
    pub(super) fn resolve(
        &self,
        material: &Material,
        index: usize,
        place: &Place,
    ) -> LocalBsdf<'_> {
        let model = match &material.bsdf {
            Bsdf::Diffuse { reflectance } => Model::Diffuse(Diffuse {
                reflectance: self.colour(*reflectance, place),
            }),
            Bsdf::Plastic {
                diffuse,
                specular,
                nonlinear,
                ..
            } => Model::Plastic(Plastic {
                coating: self.coatings[index]
                    .as_deref()
                    .expect("plastics have a coating"),
                diffuse: self.colour(*diffuse, place),
                specular: (*specular).into(),
                nonlinear: *nonlinear,
            }),
            Bsdf::Conductor {
                eta,
                k,
                specular,
                alpha,
                distribution,
            } => {
                let metal = Conductor {
                    eta: (*eta).into(),
                    k: (*k).into(),
                    specular: self.colour(*specular, place),
                };
                if *alpha > 0.0 {
                    Model::RoughConductor(metal, Microfacets::new(*distribution, *alpha))
                } else {
                    Model::Mirror(metal)
                }
            }
            Bsdf::Dielectric {
                ior,
                thin,
                reflectance,
                transmittance,
                roughness,
            } => Model::Dielectric(Dielectric {
                ior: *ior,
                thin: *thin,
                reflectance: (*reflectance).into(),
                transmittance: (*transmittance).into(),
                facets: roughness.map(|r| Microfacets::new(r.distribution, r.alpha)),
            }),
        };
        let opacity = material.opacity;
        let opacity = opacity.map_or(1.0, |source| self.share(source, place));
        LocalBsdf {
            model,
            two_sided: material.two_sided,
            opacity,
        }
    }
}

/// What a shape without a material is made of.
pub(super) fn grey<'a>() -> LocalBsdf<'a> {
    LocalBsdf {
        model: Model::Diffuse(Diffuse {
            reflectance: Vec3::splat(0.5),
        }),
        two_sided: true,
        opacity: 1.0,
    }
}
