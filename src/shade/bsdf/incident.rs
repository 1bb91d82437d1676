//! What a surface scatters to its viewer of light from many directions at once.

use glam::Vec3;
use multiversion::multiversion;

use super::conductor::Conductor;
use super::microfacet::{Microfacets, ggx_density, ggx_masking};
use super::plastic::{Coating, Plastic};
use super::{LocalBsdf, Model, fresnel};
use crate::scene::MicrofacetDistribution;

/// Light from many directions, number by number.
#[derive(Clone, Debug, Default)]
pub struct Incident {
    /// Unit vectors of the local frame, one array a coordinate.
    directions: [Vec<f32>; 3],
    /// What each brings, linear RGB: irradiance of a surface that faced it.
    power: [Vec<f32>; 3],
    /// How many there are; arrays are longer by [`LANES`] at least, and what lies beyond means nothing.
    len: usize,
    factors: Factors,
}

/// Working space: a number of each direction, in loops that processors work through many at a time.
#[derive(Clone, Debug, Default)]
struct Factors {
    /// What power is multiplied by.
    number: Vec<f32>,
    /// What facets reflect to the viewer without the Fresnel term.
    reflected: Vec<f32>,
    /// Cosine between the direction and the facet that reflects it to the viewer.
    cosine: Vec<f32>,
}

/// Directions that are worked on together.
pub const LANES: usize = 8;
/// A number of each of them.
type Lanes = [f32; LANES];

impl Incident {
    /// Takes all light away.
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Adds `count` directions that bring the same power each. `write` puts their coordinates into three arrays, which are
    /// longer than `count` by less than [`LANES`], a multiple of that; what lies beyond means nothing.
    pub fn add(&mut self, count: usize, power: Vec3, write: impl FnOnce([&mut [f32]; 3])) {
        self.make_room(count);
        let place = self.len..self.len + count.next_multiple_of(LANES);
        for (array, power) in self.power.iter_mut().zip(power.to_array()) {
            array[place.clone()].fill(power);
        }
        write(
            self.directions
                .each_mut()
                .map(|array| &mut array[place.clone()]),
        );
        self.len += count;
    }

    /// For `count` more directions, and a batch beyond them.
    fn make_room(&mut self, count: usize) {
        let least = self.len + count + 2 * LANES;
        if self.power[0].len() < least {
            let arrays = self.directions.iter_mut().chain(&mut self.power);
            arrays.for_each(|array| array.resize(2 * least, 0.0));
        }
    }

    /// Multiplies the power of the last `count` directions.
    pub fn scale_last(&mut self, count: usize, factor: f32) {
        let last = self.len - count..self.len;
        let arrays = self.power.iter_mut();
        let powers = arrays.flat_map(|array| &mut array[last.clone()]);
        powers.for_each(|power| *power *= factor);
    }

    /// How many of the last `count` directions lie on the side where z has this sign.
    pub fn above(&self, count: usize, sign: f32) -> usize {
        let z = &self.directions[2][self.len - count..self.len];
        z.iter().map(|z| usize::from(z * sign > 0.0)).sum()
    }

    /// Number of directions.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Each direction with its power.
    pub fn iter(&self) -> impl Iterator<Item = (Vec3, Vec3)> {
        let at = |[x, y, z]: &[Vec<f32>; 3], i: usize| Vec3::new(x[i], y[i], z[i]);
        (0..self.len()).map(move |i| (at(&self.directions, i), at(&self.power, i)))
    }

    /// All directions, as the material sees them from its viewer.
    fn seen(&mut self, view: Vec3, turn: f32) -> (Lit<'_>, &mut Factors) {
        self.pad();
        let count = self.len;
        let Factors {
            number,
            reflected,
            cosine,
        } = &mut self.factors;
        for array in [number, reflected, cosine] {
            array.resize(count, 0.0);
        }
        let [x, y, z] = &mut self.directions;
        z[..count].iter_mut().for_each(|z| *z *= turn);
        let lit = Lit {
            view,
            x: &x[..count],
            y: &y[..count],
            z: &z[..count],
            power: self.power.each_ref().map(|power| &power[..count]),
        };
        (lit, &mut self.factors)
    }

    /// Adds directions without light until they fill the lanes.
    fn pad(&mut self) {
        let missing = self.len.next_multiple_of(LANES) - self.len;
        self.add(missing, Vec3::ZERO, |[x, y, z]| {
            x.fill(0.0);
            y.fill(0.0);
            z.fill(-1.0);
        });
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
                let (lit, factors) = incident.seen(seen_from, turn);
                diffuse.reflectance * std::f32::consts::FRAC_1_PI * diffuse_sum(&lit, factors)
            }
            Model::Plastic(plastic) if plastic.coating.facets.is_none_or(is_plain) => {
                let (lit, factors) = incident.seen(seen_from, turn);
                plastic.scattered(&lit, factors)
            }
            Model::RoughConductor(metal, facets) if is_plain(*facets) => {
                let (lit, factors) = incident.seen(seen_from, turn);
                metal.specular * metal_sum(&lit, metal, *facets, factors)
            }
            _ => {
                let one = |(light, power): (Vec3, Vec3)| self.evaluate(view, light) * power;
                return incident.iter().map(one).sum();
            }
        };
        scattered * self.opacity
    }
}

/// Those of Beckmann take an exponential of each direction.
fn is_plain(facets: Microfacets) -> bool {
    facets.distribution() == MicrofacetDistribution::Ggx
}

impl Plastic<'_> {
    fn scattered(&self, lit: &Lit, factors: &mut Factors) -> Vec3 {
        let coating = self.coating;
        let [base, gloss] = match coating.facets {
            Some(facets) => coated_sums(lit, coating, facets, factors),
            None => [smooth_sum(lit, coating, factors), Vec3::ZERO],
        };
        let through = coating.transmittance(lit.view.z) * std::f32::consts::FRAC_1_PI;
        self.base() * through * base + self.specular * gloss
    }
}

/// Light and its viewer, on the lit side of the surface: all arrays are of the same length, a multiple of [`LANES`].
struct Lit<'a> {
    view: Vec3,
    x: &'a [f32],
    y: &'a [f32],
    z: &'a [f32],
    power: [&'a [f32]; 3],
}

impl Lit<'_> {
    /// The sum of power times a number of each direction above the surface.
    #[inline(always)]
    fn sum(&self, number: &[f32]) -> Vec3 {
        let count = number.len() / LANES * LANES;
        let [red, green, blue] = self.power;
        let (red, green, blue) = (&red[..count], &green[..count], &blue[..count]);
        let (z, number) = (&self.z[..count], &number[..count]);
        let mut sums = [[0.0; LANES]; 3];
        for first in (0..count).step_by(LANES) {
            for i in first..first + LANES {
                let lane = i - first;
                let number = if z[i] > 0.0 { number[i] } else { 0.0 };
                sums[0][lane] += red[i] * number;
                sums[1][lane] += green[i] * number;
                sums[2][lane] += blue[i] * number;
            }
        }
        Vec3::new(total(&sums[0]), total(&sums[1]), total(&sums[2]))
    }

    /// What facets (GGX) reflect to the viewer, and the cosine of that: `Microfacets::density` and `Microfacets::masking` of
    /// every direction.
    #[inline(always)]
    fn reflect(&self, facets: Microfacets, factors: &mut Factors) {
        let view = self.view;
        let alpha2 = facets.alpha() * facets.alpha();
        let scale = facets.masking(view, Vec3::Z) / (4.0 * view.z);
        let count = self.z.len();
        let (xs, ys, zs) = (&self.x[..count], &self.y[..count], &self.z[..count]);
        let reflected = &mut factors.reflected[..count];
        let cosine = &mut factors.cosine[..count];
        for i in 0..count {
            let (x, y, z) = (xs[i], ys[i], zs[i]);
            let (hx, hy, hz) = (view.x + x, view.y + y, view.z + z);
            let inverse = 1.0 / (hx * hx + hy * hy + hz * hz).sqrt();
            let (hx, hy, hz) = (hx * inverse, hy * inverse, hz * inverse);
            let towards = view.x * hx + view.y * hy + view.z * hz;
            let spread = (hx * hx + hy * hy) / alpha2 + hz * hz;
            let density = ggx_density(spread, alpha2);
            let density = if density * hz > 1e-20 { density } else { 0.0 };
            let tangent2 = (x * x + y * y) / (z * z) * alpha2;
            let masking = ggx_masking(tangent2);
            let seen = (towards > 0.0) & (x * hx + y * hy + z * hz > 0.0);
            reflected[i] = if seen { density * masking * scale } else { 0.0 };
            cosine[i] = towards;
        }
    }
}

#[inline(always)]
fn total(sums: &Lanes) -> f32 {
    let [a, b, c, d, e, f, g, h] = *sums;
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

impl Factors {
    /// Puts a number of each direction, made of a number of its own in another array, where power is multiplied.
    #[inline(always)]
    fn fill(&mut self, from: &[f32], number: impl Fn(f32) -> f32) -> &[f32] {
        for (to, &from) in self.number.iter_mut().zip(from) {
            *to = number(from);
        }
        &self.number
    }

    /// Puts what facets reflect there, with a Fresnel term of the cosine.
    #[inline(always)]
    fn gloss(&mut self, fresnel: impl Fn(f32) -> f32) -> &[f32] {
        let facets = self.reflected.iter().zip(&self.cosine);
        for (to, (reflected, &cosine)) in self.number.iter_mut().zip(facets) {
            *to = reflected * fresnel(cosine);
        }
        &self.number
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn diffuse_sum(lit: &Lit, factors: &mut Factors) -> Vec3 {
    lit.sum(factors.fill(lit.z, |z| z))
}

/// Under a smooth coating.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn smooth_sum(lit: &Lit, coating: &Coating, factors: &mut Factors) -> Vec3 {
    let ior = coating.ior;
    lit.sum(factors.fill(lit.z, |z| z * (1.0 - fresnel::outside(z.max(0.0), ior))))
}

/// Of the base and of the gloss.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn coated_sums(
    lit: &Lit,
    coating: &Coating,
    facets: Microfacets,
    factors: &mut Factors,
) -> [Vec3; 2] {
    let base = lit.sum(factors.fill(lit.z, |z| z * coating.entering_rough(z)));
    lit.reflect(facets, factors);
    let ior = coating.ior;
    let gloss = lit.sum(factors.gloss(|cosine| fresnel::outside(cosine.max(0.0), ior)));
    [base, gloss]
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn metal_sum(lit: &Lit, metal: &Conductor, facets: Microfacets, factors: &mut Factors) -> Vec3 {
    lit.reflect(facets, factors);
    let mut sum = Vec3::ZERO;
    for channel in 0..3 {
        let fresnel = |cosine: f32| metal.channel(channel, cosine.clamp(0.0, 1.0));
        sum[channel] = lit.sum(factors.gloss(fresnel))[channel];
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::super::tests::{bsdf, coatings, models};
    use super::*;
    use crate::sample::{Rng, square_to_hemisphere};

    /// Writes the same direction everywhere.
    fn along(direction: Vec3) -> impl FnOnce([&mut [f32]; 3]) {
        move |arrays| {
            let coordinates = arrays.into_iter().zip(direction.to_array());
            coordinates.for_each(|(array, coordinate)| array.fill(coordinate));
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
                let mut incident = Incident::default();
                let mut expected = Vec3::ZERO;
                for number in 0..43 {
                    // Some of them in the mirror direction, where gloss is.
                    let light = match number % 4 {
                        0 => Vec3::new(-view.x, -view.y, view.z),
                        1 => direction(-side),
                        _ => direction(side),
                    };
                    let power = Vec3::new(1.0, 0.1, 3.0) * (1.0 + number as f32);
                    expected += bsdf.evaluate(view, light) * power;
                    incident.add(1, power, along(light));
                }
                let found = bsdf.scattered(view, &mut incident);
                let off = (found - expected).abs().max_element();
                let most = 1e-5 * expected.max_element();
                assert!(off <= most, "{name}: {found} {expected}");
            }
        }
    }

    #[test]
    fn directions_are_counted_and_scaled_from_the_last() {
        let mut incident = Incident::default();
        assert!(incident.is_empty());
        incident.add(2, Vec3::ONE, |[x, y, z]| {
            assert_eq!([x.len(), y.len(), z.len()], [LANES; 3]);
            z[..2].copy_from_slice(&[1.0, -1.0]);
        });
        incident.add(1, Vec3::ONE, along(Vec3::NEG_Z));
        assert_eq!((incident.above(3, 1.0), incident.above(2, -1.0)), (1, 2));
        incident.scale_last(1, 2.0);
        let power: Vec<f32> = incident.iter().map(|(_, power)| power.x).collect();
        assert_eq!(power, [1.0, 1.0, 2.0]);
        incident.clear();
        assert_eq!(incident.len(), 0);
    }
}
