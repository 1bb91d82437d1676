//! What a surface scatters to its viewer of light that spreads over many cones.

use std::f32::consts::{FRAC_1_PI, TAU};

use glam::Vec3;
use macro_rules_attribute::apply;

use super::conductor::Conductor;
use super::microfacet::{GgxMirror, Microfacets};
use super::plastic::{Coating, Plastic};
use super::{LocalBsdf, Model, fresnel};
use crate::instructions::compiled_for_avx512;
use crate::scene::MicrofacetDistribution;

/// Light that spreads evenly over a cone.
#[derive(Clone, Copy, Debug)]
pub struct LightCone {
    /// Unit vectors of the local frame: two across the axis, and the axis.
    pub axes: [Vec3; 3],
    /// 1 − cos α of the half angle α.
    pub height: f32,
    /// Linear RGB: irradiance of a surface that faced all of it.
    pub power: Vec3,
    /// In how many directions it is put into the material.
    pub directions: usize,
}

/// Light of several cones, and directions that spread over them.
#[derive(Clone, Debug)]
pub struct Incident {
    cones: Vec<LightCone>,
    /// Whether the directions of a cone above the surface bring the light of those below it too.
    renormalised: bool,
    /// Turns of directions around the axis of their cone.
    turns: Turns,
    /// Of all cones, one after another.
    directions: Directions,
}

/// Numbers of directions, in loops that processors work through many at a time: what lies beyond the last direction means
/// nothing.
#[derive(Clone, Debug, Default)]
struct Directions {
    /// How many there are.
    len: usize,
    /// Unit vectors of the local frame.
    x: Vec<f32>,
    y: Vec<f32>,
    z: Vec<f32>,
    /// What the material scatters of each: two numbers, for materials of two parts.
    first: Vec<f32>,
    second: Vec<f32>,
}

/// Cosines and sines of angles, one golden angle after another.
#[derive(Clone, Debug)]
struct Turns {
    cosines: Vec<f32>,
    sines: Vec<f32>,
}

/// The golden ratio's fractional part.
const GOLDEN_TURN: f32 = 0.618_034;
/// Directions are worked on this many at a time: those of a cone when they are made, those of all cones together in the
/// material.
const BATCH: usize = 16;

impl Turns {
    /// Those of at least `count` directions.
    fn new(count: usize) -> Self {
        let count = count.next_multiple_of(BATCH);
        let angle = |i: usize| TAU * (i as f32 * GOLDEN_TURN).fract();
        Self {
            cosines: (0..count).map(|i| angle(i).cos()).collect(),
            sines: (0..count).map(|i| angle(i).sin()).collect(),
        }
    }
}

impl Incident {
    /// No light yet; cones have `most_directions` at most.
    pub fn new(most_directions: usize, renormalised: bool) -> Self {
        Self {
            cones: Vec::new(),
            renormalised,
            turns: Turns::new(most_directions),
            directions: Directions::default(),
        }
    }

    /// Takes all light away.
    pub fn clear(&mut self) {
        self.cones.clear();
        self.directions.len = 0;
    }

    /// Adds the light of a cone.
    pub fn add(&mut self, cone: LightCone) {
        self.directions.len += cone.directions;
        self.cones.push(cone);
    }

    /// Whether there is no light.
    pub fn is_empty(&self) -> bool {
        self.cones.is_empty()
    }

    /// Makes the directions, mirrored at the surface where `turn` is −1. Above is where z is positive after that. Once for the
    /// light that was added: where it is renormalised, the power of cones changes.
    #[inline(always)]
    fn spread(&mut self, turn: f32) {
        self.directions.make_room();
        let Directions { x, y, z, .. } = &mut self.directions;
        let mut start = 0;
        for cone in &mut self.cones {
            let step = cone.height / cone.directions as f32;
            let [across, along, axis] = cone.axes.map(|v| v * Vec3::new(1.0, 1.0, turn));
            let count = cone.directions.next_multiple_of(BATCH);
            let place = start..start + count;
            let (x, y, z) = (&mut x[place.clone()], &mut y[place.clone()], &mut z[place]);
            let (cosines, sines) = (&self.turns.cosines[..count], &self.turns.sines[..count]);
            for i in 0..count {
                let depth = (i as i32 as f32 + 0.5) * step;
                let sine = (depth * (2.0 - depth)).max(0.0).sqrt();
                let (right, up) = (sine * cosines[i], sine * sines[i]);
                let ahead = 1.0 - depth;
                x[i] = across.x * right + along.x * up + axis.x * ahead;
                y[i] = across.y * right + along.y * up + axis.y * ahead;
                z[i] = across.z * right + along.z * up + axis.z * ahead;
            }
            if self.renormalised {
                let above = z[..cone.directions].iter().filter(|z| **z > 0.0).count();
                cone.power *= cone.directions as f32 / above.max(1) as f32;
            }
            start += cone.directions;
        }
    }

    /// Each direction with its power, from the viewer's side `side` (the sign of z).
    pub fn each(&mut self, side: f32) -> impl Iterator<Item = (Vec3, Vec3)> {
        self.spread(side);
        let Directions { x, y, z, .. } = &self.directions;
        let powers = self.cones.iter().flat_map(|cone| {
            let power = cone.power / cone.directions as f32;
            std::iter::repeat_n(power, cone.directions)
        });
        powers.enumerate().map(move |(i, power)| {
            let direction = Vec3::new(x[i], y[i], side * z[i]);
            (direction, power)
        })
    }

    /// The sum over directions of power times numbers of them.
    #[inline(always)]
    fn sum(&self, numbers: &[f32]) -> Vec3 {
        let mut sum = Vec3::ZERO;
        let mut start = 0;
        for cone in &self.cones {
            let end = start + cone.directions;
            let number: f32 = numbers[start..end].iter().sum();
            sum += cone.power * (number / cone.directions as f32);
            start = end;
        }
        sum
    }
}

impl Directions {
    /// For all directions, and a batch beyond them.
    fn make_room(&mut self) {
        let least = self.len.next_multiple_of(BATCH) + BATCH;
        if self.x.len() < least {
            let Self {
                x,
                y,
                z,
                first,
                second,
                ..
            } = self;
            let arrays = [x, y, z, first, second];
            arrays
                .into_iter()
                .for_each(|array| array.resize(2 * least, 0.0));
        }
    }

    /// Puts a number of each direction above the surface, of the cosine to the normal there, into `first`, and 0 for the
    /// others.
    #[inline(always)]
    fn fill(&mut self, number: impl Fn(f32) -> f32) {
        let count = self.len.next_multiple_of(BATCH);
        let (z, first) = (&self.z[..count], &mut self.first[..count]);
        for i in 0..count {
            let cosine = z[i].max(0.0);
            first[i] = if z[i] > 0.0 { number(cosine) } else { 0.0 };
        }
    }

    /// Puts what facets (GGX) reflect to the viewer of each direction into `second`; `fresnel` is told the cosine between
    /// the direction and the facet.
    #[inline(always)]
    fn reflect(&mut self, view: Vec3, facets: Microfacets, fresnel: impl Fn(f32) -> f32) {
        let count = self.len.next_multiple_of(BATCH);
        let (x, y, z) = (&self.x[..count], &self.y[..count], &self.z[..count]);
        let second = &mut self.second[..count];
        let mirror = GgxMirror::new(facets, view);
        for i in 0..count {
            let (reflected, cosine) = mirror.reflected(x[i], y[i], z[i]);
            second[i] = reflected * fresnel(cosine);
        }
    }
}

impl LocalBsdf<'_> {
    /// The sum of [`LocalBsdf::evaluate`] times power over all directions, up to rounding.
    pub fn scattered(&self, view: Vec3, incident: &mut Incident) -> Vec3 {
        let turn = self.two_sided_turn(view).z;
        let seen_from = view * Vec3::new(1.0, 1.0, turn);
        if seen_from.z <= 0.0 {
            return Vec3::ZERO;
        }
        let scattered = match &self.model {
            Model::Diffuse(diffuse) => {
                diffuse.reflectance * FRAC_1_PI * diffuse_sum(incident, turn)
            }
            Model::Plastic(plastic) if plastic.coating.facets.is_none_or(is_plain) => {
                plastic.scattered(seen_from, incident, turn)
            }
            Model::RoughConductor(metal, facets) if is_plain(*facets) => {
                metal.specular * metal_sum(incident, turn, seen_from, metal, *facets)
            }
            _ => {
                let one = |(light, power): (Vec3, Vec3)| self.evaluate(view, light) * power;
                return incident.each(turn).map(one).sum();
            }
        };
        scattered * self.opacity
    }
}

/// Those of Beckmann take an exponential of each direction.
pub(super) fn is_plain(facets: Microfacets) -> bool {
    facets.distribution() == MicrofacetDistribution::Ggx
}

impl Plastic<'_> {
    fn scattered(&self, view: Vec3, incident: &mut Incident, turn: f32) -> Vec3 {
        let coating = self.coating;
        let [base, gloss] = match coating.facets {
            Some(facets) => coated_sums(incident, turn, view, coating, facets),
            None => [smooth_sum(incident, turn, coating), Vec3::ZERO],
        };
        let [of_base, of_gloss] = self.weights(view.z);
        of_base * base + of_gloss * gloss
    }
}

#[apply(compiled_for_avx512)]
fn diffuse_sum(incident: &mut Incident, turn: f32) -> Vec3 {
    incident.spread(turn);
    incident.directions.fill(|cosine| cosine);
    incident.sum(&incident.directions.first)
}

/// Under a smooth coating.
#[apply(compiled_for_avx512)]
fn smooth_sum(incident: &mut Incident, turn: f32, coating: &Coating) -> Vec3 {
    incident.spread(turn);
    let ior = coating.ior;
    let entering = |cosine: f32| cosine * (1.0 - fresnel::outside(cosine, ior));
    incident.directions.fill(entering);
    incident.sum(&incident.directions.first)
}

/// Of the base and of the gloss.
#[apply(compiled_for_avx512)]
fn coated_sums(
    incident: &mut Incident,
    turn: f32,
    view: Vec3,
    coating: &Coating,
    facets: Microfacets,
) -> [Vec3; 2] {
    incident.spread(turn);
    let directions = &mut incident.directions;
    directions.fill(|cosine| cosine * coating.entering_rough(cosine));
    let ior = coating.ior;
    directions.reflect(view, facets, |cosine| fresnel::outside(cosine, ior));
    let directions = &incident.directions;
    [&directions.first, &directions.second].map(|numbers| incident.sum(numbers))
}

#[apply(compiled_for_avx512)]
fn metal_sum(
    incident: &mut Incident,
    turn: f32,
    view: Vec3,
    metal: &Conductor,
    facets: Microfacets,
) -> Vec3 {
    incident.spread(turn);
    let mut sum = Vec3::ZERO;
    for channel in 0..3 {
        let fresnel = |cosine: f32| metal.channel(channel, cosine);
        incident.directions.reflect(view, facets, fresnel);
        sum[channel] = incident.sum(&incident.directions.second)[channel];
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::super::tests::{bsdf, coatings, models};
    use super::*;
    use crate::sample::{Frame, Rng, square_to_hemisphere};

    /// A cone about an axis.
    fn cone(axis: Vec3, height: f32, power: Vec3, directions: usize) -> LightCone {
        let frame = Frame::from_normal(axis);
        LightCone {
            axes: [frame.tangent, frame.bitangent, frame.normal],
            height,
            power,
            directions,
        }
    }

    #[test]
    fn sums_over_many_directions_are_those_of_one_after_another() {
        let coatings = coatings();
        let mut rng = Rng::new(11, 0, 0, 0);
        let mut direction = |side: f32| {
            let upper = square_to_hemisphere(rng.next_f32(), rng.next_f32());
            upper * Vec3::new(1.0, 1.0, side)
        };
        for (name, model) in models(&coatings) {
            for (two_sided, side) in [(false, 1.0), (true, -1.0), (false, -1.0)] {
                let bsdf = LocalBsdf {
                    two_sided,
                    opacity: 0.7,
                    ..bsdf(model)
                };
                let view = direction(side);
                let mut incident = Incident::new(16, false);
                for number in 0..13 {
                    // Some of them in the mirror direction, where gloss is, and some wide ones across the horizon.
                    let axis = match number % 4 {
                        0 => Vec3::new(-view.x, -view.y, view.z),
                        1 => direction(-side),
                        _ => direction(side),
                    };
                    let height = [0.0, 1e-4, 0.02, 0.6, 2.0][number % 5];
                    let power = Vec3::new(1.0, 0.1, 3.0) * (1.0 + number as f32);
                    incident.add(cone(axis, height, power, 1 + (5 * number) % 16));
                }
                let one = |(light, power): (Vec3, Vec3)| bsdf.evaluate(view, light) * power;
                let expected: Vec3 = incident.each(side).map(one).sum();
                let found = bsdf.scattered(view, &mut incident);
                let off = (found - expected).abs().max_element();
                let most = 1e-5 * expected.max_element();
                assert!(off <= most, "{name}: {found} {expected}");
            }
        }
    }

    #[test]
    fn directions_lie_in_their_cone_and_have_its_axis_as_their_mean() {
        let axis = Vec3::new(0.3, -0.5, 0.8).normalize();
        let mut incident = Incident::new(64, false);
        assert!(incident.is_empty());
        incident.add(cone(axis, 0.3, Vec3::ONE, 64));
        let directions: Vec<(Vec3, Vec3)> = incident.each(1.0).collect();
        assert_eq!(directions.len(), 64);
        let mut mean = Vec3::ZERO;
        for (direction, power) in directions {
            assert!((direction.length() - 1.0).abs() < 1e-5 && direction.dot(axis) > 0.7 - 1e-5);
            mean += direction * power;
        }
        assert!((mean - 0.85 * axis).length() < 0.02, "{mean}");
        incident.clear();
        assert!(incident.is_empty() && incident.each(1.0).next().is_none());
    }

    #[test]
    fn light_below_the_surface_is_lost_or_brought_by_the_directions_above() {
        for (renormalised, expected) in [(false, 0.5), (true, 1.0)] {
            for side in [1.0, -1.0] {
                let mut incident = Incident::new(16, renormalised);
                incident.add(cone(Vec3::X, 0.5, Vec3::ONE, 16));
                incident.add(cone(Vec3::Z * -side, 0.1, Vec3::ONE, 3));
                let above = incident.each(side).filter(|(v, _)| v.z * side > 0.0);
                let power: f32 = above.map(|(_, power)| power.x).sum();
                assert!((power - expected).abs() < 0.1, "{power} {expected}");
            }
        }
    }
}
