//! An interaction without its borrow of the materials, to be stored.

use glam::{Vec2, Vec3};

use super::{Interaction, Surfaces};
use crate::sample::Frame;
use crate::shade::bsdf::{Conductor, Dielectric, Diffuse, LocalBsdf, Microfacets, Model, Plastic};

/// A stored [`Interaction`]; [`Surfaces::recall`] of the surfaces that made it brings it back.
#[derive(Clone, Copy, Debug)]
pub struct Kept {
    position: Vec3,
    geometric_normal: Vec3,
    shading_normal: Vec3,
    uv: Vec2,
    shape: u32,
    triangle: u32,
    frame: Frame,
    view: Vec3,
    model: KeptModel,
    two_sided: bool,
    opacity: f32,
}

#[derive(Clone, Copy, Debug)]
enum KeptModel {
    Diffuse(Diffuse),
    Plastic {
        /// Index into the coatings of the surfaces.
        coating: u32,
        diffuse: Vec3,
        specular: Vec3,
        nonlinear: bool,
    },
    Mirror(Conductor),
    RoughConductor(Conductor, Microfacets),
    Dielectric(Dielectric),
}

impl Surfaces<'_> {
    /// Stores an interaction that these surfaces made.
    pub fn keep(&self, at: &Interaction) -> Kept {
        Kept {
            position: at.position,
            geometric_normal: at.geometric_normal,
            shading_normal: at.shading_normal,
            uv: at.uv,
            shape: at.shape,
            triangle: at.triangle,
            frame: at.frame,
            view: at.view,
            model: match at.bsdf.model {
                Model::Diffuse(m) => KeptModel::Diffuse(m),
                Model::Plastic(m) => KeptModel::Plastic {
                    coating: self.coating_index(at.shape) as u32,
                    diffuse: m.diffuse,
                    specular: m.specular,
                    nonlinear: m.nonlinear,
                },
                Model::Mirror(m) => KeptModel::Mirror(m),
                Model::RoughConductor(m, facets) => KeptModel::RoughConductor(m, facets),
                Model::Dielectric(m) => KeptModel::Dielectric(m),
            },
            two_sided: at.bsdf.two_sided,
            opacity: at.bsdf.opacity,
        }
    }

    /// The interaction that was kept.
    pub fn recall(&self, kept: &Kept) -> Interaction<'_> {
        let model = match kept.model {
            KeptModel::Diffuse(m) => Model::Diffuse(m),
            KeptModel::Plastic {
                coating,
                diffuse,
                specular,
                nonlinear,
            } => Model::Plastic(Plastic {
                coating: &self.coatings[coating as usize],
                diffuse,
                specular,
                nonlinear,
            }),
            KeptModel::Mirror(m) => Model::Mirror(m),
            KeptModel::RoughConductor(m, facets) => Model::RoughConductor(m, facets),
            KeptModel::Dielectric(m) => Model::Dielectric(m),
        };
        Interaction {
            position: kept.position,
            geometric_normal: kept.geometric_normal,
            shading_normal: kept.shading_normal,
            uv: kept.uv,
            shape: kept.shape,
            triangle: kept.triangle,
            bsdf: LocalBsdf {
                model,
                two_sided: kept.two_sided,
                opacity: kept.opacity,
            },
            frame: kept.frame,
            view: kept.view,
            local_view: kept.frame.to_local(kept.view),
        }
    }

    fn coating_index(&self, shape: u32) -> usize {
        let material = self.scene.shapes.get(shape as usize);
        let material = material.map_or(0, |s| s.material) as usize;
        self.coating_of.get(material).copied().unwrap_or(0)
    }
}
