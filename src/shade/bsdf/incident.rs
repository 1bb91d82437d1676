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
}

/// Directions that are worked on together.
pub const LANES: usize = 8;
/// A number of each of them.
pub type Lanes = [f32; LANES];
/// Sums of power times a number of each direction: of the base, and of the gloss.
type Sums = [[Lanes; 3]; 2];

impl Incident {
    /// Takes all light away.
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Adds `count` directions that bring the same power each. `made` gives the coordinates of those of a batch of [`LANES`];
    /// what is beyond `count` in the last batch is left out.
    #[inline(always)]
    pub fn add(&mut self, count: usize, power: Vec3, made: impl Fn(usize) -> [Lanes; 3]) {
        self.make_room(count);
        for batch in 0..count.div_ceil(LANES) {
            self.write(self.len + batch * LANES, made(batch), power);
        }
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

    fn write(&mut self, at: usize, directions: [Lanes; 3], power: Vec3) {
        let place = at..at + LANES;
        for (array, lanes) in self.directions.iter_mut().zip(directions) {
            array[place.clone()].copy_from_slice(&lanes);
        }
        for (array, power) in self.power.iter_mut().zip(power.to_array()) {
            array[place.clone()].fill(power);
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

    /// Adds directions without light until they fill the lanes.
    fn pad(&mut self) {
        self.make_room(LANES);
        let padding = [[0.0; LANES], [0.0; LANES], [-1.0; LANES]];
        self.write(self.len, padding, Vec3::ZERO);
        self.len = self.len.next_multiple_of(LANES);
    }
}

impl LocalBsdf<'_> {
    /// The sum of [`LocalBsdf::evaluate`] times power over all directions, up to rounding.
    pub fn scattered(&self, view: Vec3, incident: &mut Incident) -> Vec3 {
        let turn = self.two_sided_turn(view).z;
        let lit = View {
            view: view * Vec3::new(1.0, 1.0, turn),
            turn,
        };
        if lit.view.z <= 0.0 {
            return Vec3::ZERO;
        }
        let scattered = match &self.model {
            Model::Diffuse(diffuse) => {
                incident.pad();
                let [base, _] = totals(&diffuse_sums(&lit, incident));
                diffuse.reflectance * std::f32::consts::FRAC_1_PI * base
            }
            Model::Plastic(plastic) if plastic.coating.facets.is_none_or(is_plain) => {
                incident.pad();
                plastic.scattered(&lit, incident)
            }
            Model::RoughConductor(metal, facets) if is_plain(*facets) => {
                incident.pad();
                let [_, gloss] = totals(&metal_sums(&lit, metal, *facets, incident));
                metal.specular * gloss
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
    fn scattered(&self, lit: &View, incident: &Incident) -> Vec3 {
        let coating = self.coating;
        let sums = match coating.facets {
            Some(facets) => coated_sums(lit, coating, facets, incident),
            None => smooth_sums(lit, coating, incident),
        };
        let [base, gloss] = totals(&sums);
        let through = coating.transmittance(lit.view.z) * std::f32::consts::FRAC_1_PI;
        self.base() * through * base + self.specular * gloss
    }
}

/// Where a surface is seen from, on its lit side.
struct View {
    view: Vec3,
    /// What z of light is multiplied by.
    turn: f32,
}

/// Directions that are worked on together, with z on the viewer's side.
struct Batch {
    x: Lanes,
    y: Lanes,
    z: Lanes,
    power: [Lanes; 3],
}

impl View {
    #[inline(always)]
    fn batches<'a>(&self, incident: &'a Incident) -> impl Iterator<Item = Batch> + use<'a> {
        let turn = self.turn;
        (0..incident.len() / LANES).map(move |batch| {
            let lanes = |array: &[f32]| {
                let mut lanes = [0.0; LANES];
                lanes.copy_from_slice(&array[batch * LANES..][..LANES]);
                lanes
            };
            let [x, y, z] = &incident.directions;
            Batch {
                x: lanes(x),
                y: lanes(y),
                z: lanes(z).map(|z| z * turn),
                power: [0, 1, 2].map(|c| lanes(&incident.power[c])),
            }
        })
    }
}

impl Batch {
    /// Adds a number of each direction above the surface, times its power.
    #[inline(always)]
    fn add(&self, sums: &mut [Lanes; 3], number: &Lanes) {
        for (channel, sum) in sums.iter_mut().enumerate() {
            self.add_to(sum, channel, number);
        }
    }

    /// The same of one channel.
    #[inline(always)]
    fn add_to(&self, sum: &mut Lanes, channel: usize, number: &Lanes) {
        for lane in 0..LANES {
            let number = if self.z[lane] > 0.0 {
                number[lane]
            } else {
                0.0
            };
            sum[lane] += self.power[channel][lane] * number;
        }
    }

    /// What facets (GGX) reflect to the viewer without the Fresnel term, and the cosine of that: `Microfacets::density` and
    /// `Microfacets::masking` of eight directions.
    #[inline(always)]
    fn reflected(&self, lit: &View, facets: Microfacets, view_masking: f32) -> [Lanes; 2] {
        let view = lit.view;
        let alpha2 = facets.alpha() * facets.alpha();
        let scale = view_masking / (4.0 * view.z);
        let (mut reflected, mut cosine) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            let (x, y, z) = (self.x[lane], self.y[lane], self.z[lane]);
            let (hx, hy, hz) = (view.x + x, view.y + y, view.z + z);
            let inverse = 1.0 / (hx * hx + hy * hy + hz * hz).sqrt();
            let (hx, hy, hz) = (hx * inverse, hy * inverse, hz * inverse);
            let towards = view.x * hx + view.y * hy + view.z * hz;
            let spread = (hx * hx + hy * hy) / alpha2 + hz * hz;
            let density = ggx_density(spread, alpha2);
            let density = if density * hz > 1e-20 { density } else { 0.0 };
            let tangent2 = (x * x + y * y) / (z * z) * alpha2;
            let masking = ggx_masking(tangent2);
            let seen = towards > 0.0 && x * hx + y * hy + z * hz > 0.0;
            reflected[lane] = if seen { density * masking * scale } else { 0.0 };
            cosine[lane] = towards;
        }
        [reflected, cosine]
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn diffuse_sums(lit: &View, incident: &Incident) -> Sums {
    let mut sums = Sums::default();
    for batch in lit.batches(incident) {
        batch.add(&mut sums[0], &batch.z);
    }
    sums
}

/// Under a smooth coating.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn smooth_sums(lit: &View, coating: &Coating, incident: &Incident) -> Sums {
    let mut sums = Sums::default();
    for batch in lit.batches(incident) {
        let base = batch
            .z
            .map(|z| z * (1.0 - fresnel::outside(z.max(0.0), coating.ior)));
        batch.add(&mut sums[0], &base);
    }
    sums
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn coated_sums(lit: &View, coating: &Coating, facets: Microfacets, incident: &Incident) -> Sums {
    let view_masking = facets.masking(lit.view, Vec3::Z);
    let mut sums = Sums::default();
    for batch in lit.batches(incident) {
        let base = batch.z.map(|z| z * coating.entering_rough(z));
        batch.add(&mut sums[0], &base);
        let [mut gloss, cosine] = batch.reflected(lit, facets, view_masking);
        for lane in 0..LANES {
            gloss[lane] *= fresnel::outside(cosine[lane].max(0.0), coating.ior);
        }
        batch.add(&mut sums[1], &gloss);
    }
    sums
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn metal_sums(lit: &View, metal: &Conductor, facets: Microfacets, incident: &Incident) -> Sums {
    let view_masking = facets.masking(lit.view, Vec3::Z);
    let mut sums = Sums::default();
    for batch in lit.batches(incident) {
        let [gloss, cosine] = batch.reflected(lit, facets, view_masking);
        for (channel, sum) in sums[1].iter_mut().enumerate() {
            let mut coloured = gloss;
            for lane in 0..LANES {
                let cosine = cosine[lane].clamp(0.0, 1.0);
                coloured[lane] *= metal.channel(channel, cosine);
            }
            batch.add_to(sum, channel, &coloured);
        }
    }
    sums
}

fn totals(sums: &Sums) -> [Vec3; 2] {
    sums.map(|channels| {
        let sum = |lanes: Lanes| {
            let half: [f32; 4] = std::array::from_fn(|i| lanes[i] + lanes[i + 4]);
            (half[0] + half[2]) + (half[1] + half[3])
        };
        Vec3::from(channels.map(sum))
    })
}

#[cfg(test)]
mod tests {
    use super::super::tests::{bsdf, coatings, models};
    use super::*;
    use crate::sample::{Rng, square_to_hemisphere};

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
                    incident.add(1, power, |_| light.to_array().map(|x| [x; LANES]));
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
        let two_sides = std::array::from_fn(|lane| if lane == 0 { 1.0 } else { -1.0 });
        let upright = |z: Lanes| [[0.0; LANES], [0.0; LANES], z];
        incident.add(2, Vec3::ONE, |_| upright(two_sides));
        incident.add(1, Vec3::ONE, |_| upright([-1.0; LANES]));
        assert_eq!((incident.above(3, 1.0), incident.above(2, -1.0)), (1, 2));
        incident.scale_last(1, 2.0);
        let power: Vec<f32> = incident.iter().map(|(_, power)| power.x).collect();
        assert_eq!(power, [1.0, 1.0, 2.0]);
        incident.clear();
        assert_eq!(incident.len(), 0);
    }
}
