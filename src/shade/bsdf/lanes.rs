//! What a surface scatters to its viewer of many lights, each in a direction of its own: luminances, which select lights.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;
use macro_rules_attribute::apply;

use super::conductor::Conductor;
use super::incident::is_plain;
use super::microfacet::{GgxMirror, Microfacets};
use super::plastic::Coating;
use super::{LocalBsdf, Model, fresnel};
use crate::image::LUMINANCE;
use crate::instructions::compiled_for_avx512;
use crate::sample::Frame;

/// Lights that are worked on together.
pub const LANES: usize = 32;
/// A number of each of them.
pub type Lanes = [f32; LANES];
/// A vector of each of them, one array a coordinate.
pub type VectorLanes = [Lanes; 3];

/// What two parts of a material scatter of each direction, times the cosine to the normal.
struct Parts {
    base: Lanes,
    gloss: Lanes,
}

impl LocalBsdf<'_> {
    /// Luminance of [`LocalBsdf::evaluate`] times irradiance, for unit directions of the local frame, up to rounding. `None` of
    /// materials that are evaluated one direction after another.
    pub fn luminances(
        &self,
        view: Vec3,
        directions: &VectorLanes,
        irradiance: &VectorLanes,
    ) -> Option<Lanes> {
        let turn = self.two_sided_turn(view).z;
        let seen_from = view * Vec3::new(1.0, 1.0, turn);
        let mut luminances = [0.0; LANES];
        if seen_from.z <= 0.0 {
            return Some(luminances);
        }
        let [x, y, z] = directions;
        let z = &z.map(|z| z * turn);
        let mut parts = Parts {
            base: [0.0; LANES],
            gloss: [0.0; LANES],
        };
        let weights = match &self.model {
            Model::Diffuse(diffuse) => {
                facing(z, &mut parts.base);
                [diffuse.reflectance * FRAC_1_PI, Vec3::ZERO]
            }
            Model::Plastic(plastic) if plastic.coating.facets.is_none_or(is_plain) => {
                let coating = plastic.coating;
                match coating.facets {
                    Some(facets) => coated([x, y, z], seen_from, coating, facets, &mut parts),
                    None => under_smooth(z, coating, &mut parts.base),
                }
                plastic.weights(seen_from.z)
            }
            Model::RoughConductor(metal, facets) if is_plain(*facets) => {
                let weights = metal.specular * Vec3::from(LUMINANCE) * self.opacity;
                let lit = [irradiance, &[*x, *y, *z]];
                metallic(lit, seen_from, metal, *facets, weights, &mut luminances);
                return Some(luminances);
            }
            _ => return None,
        };
        let weights = weights.map(|weight| weight * Vec3::from(LUMINANCE) * self.opacity);
        weigh(&parts, irradiance, weights, &mut luminances);
        Some(luminances)
    }
}

/// World directions in a frame.
#[apply(compiled_for_avx512)]
pub fn to_local(directions: &VectorLanes, frame: &Frame, local: &mut VectorLanes) {
    let [x, y, z] = directions;
    let axes = [frame.tangent, frame.bitangent, frame.normal];
    for (axis, local) in axes.iter().zip(local) {
        for lane in 0..LANES {
            local[lane] = x[lane] * axis.x + y[lane] * axis.y + z[lane] * axis.z;
        }
    }
}

#[apply(compiled_for_avx512)]
fn facing(z: &Lanes, base: &mut Lanes) {
    for i in 0..LANES {
        base[i] = z[i].max(0.0);
    }
}

/// The base under a smooth coating.
#[apply(compiled_for_avx512)]
fn under_smooth(z: &Lanes, coating: &Coating, base: &mut Lanes) {
    let ior = coating.ior;
    for i in 0..LANES {
        let cosine = z[i].max(0.0);
        base[i] = cosine * (1.0 - fresnel::outside(cosine, ior));
    }
}

/// The base under a rough coating, and the coating's gloss.
#[apply(compiled_for_avx512)]
fn coated(
    directions: [&Lanes; 3],
    view: Vec3,
    coating: &Coating,
    facets: Microfacets,
    parts: &mut Parts,
) {
    let [x, y, z] = directions;
    let mirror = GgxMirror::new(facets, view);
    let ior = coating.ior;
    let Parts { base, gloss } = parts;
    for i in 0..LANES {
        let cosine = z[i].max(0.0);
        base[i] = cosine * coating.entering_rough(cosine);
    }
    for i in 0..LANES {
        let (reflected, cosine) = mirror.reflected(x[i], y[i], z[i]);
        gloss[i] = reflected * fresnel::outside(cosine, ior);
    }
}

#[apply(compiled_for_avx512)]
fn metallic(
    lit: [&VectorLanes; 2],
    view: Vec3,
    metal: &Conductor,
    facets: Microfacets,
    weights: Vec3,
    luminances: &mut Lanes,
) {
    let [[red, green, blue], [x, y, z]] = lit;
    let mirror = GgxMirror::new(facets, view);
    for i in 0..LANES {
        let (reflected, cosine) = mirror.reflected(x[i], y[i], z[i]);
        let light = weights.x * red[i] * metal.channel(0, cosine)
            + weights.y * green[i] * metal.channel(1, cosine)
            + weights.z * blue[i] * metal.channel(2, cosine);
        luminances[i] = reflected * light;
    }
}

#[apply(compiled_for_avx512)]
fn weigh(parts: &Parts, irradiance: &VectorLanes, weights: [Vec3; 2], luminances: &mut Lanes) {
    let [red, green, blue] = irradiance;
    let [base, gloss] = weights;
    for i in 0..LANES {
        let under = base.x * red[i] + base.y * green[i] + base.z * blue[i];
        let on = gloss.x * red[i] + gloss.y * green[i] + gloss.z * blue[i];
        luminances[i] = parts.base[i] * under + parts.gloss[i] * on;
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{bsdf, coatings, models};
    use super::*;
    use crate::image::luminance;
    use crate::sample::{Rng, square_to_hemisphere};

    #[test]
    fn luminances_of_many_lights_are_those_of_one_after_another() {
        let coatings = coatings();
        let mut rng = Rng::new(5, 0, 0, 0);
        let mut many = 0;
        for (name, model) in models(&coatings) {
            for (two_sided, side) in [(false, 1.0), (true, -1.0), (false, -1.0)] {
                let bsdf = LocalBsdf {
                    two_sided,
                    opacity: 0.7,
                    ..bsdf(model)
                };
                let mut direction = || {
                    let upper = square_to_hemisphere(rng.next_f32(), rng.next_f32());
                    upper * Vec3::new(1.0, 1.0, side)
                };
                let view = direction();
                let lights: Vec<(Vec3, Vec3)> = (0..LANES)
                    .map(|lane| {
                        let number = lane as f32;
                        let power = Vec3::new(1.0 + number, 3.0, 0.1 * number);
                        match lane % 4 {
                            0 => (Vec3::new(-view.x, -view.y, view.z), power),
                            1 => (direction() * Vec3::new(1.0, 1.0, -1.0), power),
                            2 => (direction(), Vec3::ZERO),
                            _ => (direction(), power),
                        }
                    })
                    .collect();
                let mut lanes = [[[0.0; LANES]; 3]; 2];
                for (lane, (direction, power)) in lights.iter().enumerate() {
                    for axis in 0..3 {
                        lanes[0][axis][lane] = direction[axis];
                        lanes[1][axis][lane] = power[axis];
                    }
                }
                let Some(found) = bsdf.luminances(view, &lanes[0], &lanes[1]) else {
                    continue;
                };
                many += 1;
                for ((direction, power), found) in lights.iter().zip(found) {
                    let expected = luminance((bsdf.evaluate(view, *direction) * *power).into());
                    let off = (found - expected).abs();
                    assert!(
                        off <= 1e-5 * expected.abs() + 1e-9,
                        "{name}: {found} {expected}"
                    );
                }
            }
        }
        assert!(many >= 12, "{many}");
    }
}
