//! Unshadowed contributions of all lights at a shading point.
//!
//! Chunks of eight lights are looked at first, as if each were one light; where such a chunk makes a
//! highlight, its lights take its place. A surface scatters by up to three terms, each a colour times a
//! number a light: the loops work on the numbers of eight lights at once.

use glam::Vec3;

use super::irradiance::Irradiance;
use super::lights::{Chunk, LANES, Lane, LightArrays, larger};
use super::terms::{Numbers, Terms};

/// Contributions at one point; reused from point to point.
#[derive(Default)]
pub(super) struct Contributions {
    /// Of the parents: each lane is a chunk.
    parents: Vec<Numbers>,
    /// Σ c_j of every chunk.
    weights: Vec<f32>,
    /// Running sums of the weights.
    pub running: Vec<f32>,
    /// The place of a chunk's own numbers in `refined`, or [`NONE`].
    own: Vec<u32>,
    refined: Vec<(Numbers, Lane)>,
    /// U of both groups.
    pub unshadowed: [Vec3; 2],
    colours: [Vec3; 3],
    luminances: [[f32; 3]; 3],
    count: usize,
}

const NONE: u32 = u32::MAX;
const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// Which lights are looked at one by one.
#[derive(Clone, Copy)]
pub(super) enum Detail {
    /// Those of chunks whose highlight has this share of all light.
    Highlights(f32),
    All,
}

/// Power of a term by group and channel.
type Sums = [[Vec3; 2]; 4];

impl Contributions {
    /// Evaluates the lights.
    pub fn evaluate(
        &mut self,
        (lights, irradiance): (&LightArrays, &Irradiance),
        terms: &Terms,
        detail: Detail,
    ) {
        (self.colours, self.count) = (terms.colours, terms.count);
        self.luminances = terms
            .colours
            .map(|colour| [0, 1, 2].map(|c| LUMINANCE[c] * colour[c]));
        self.look_at_chunks(lights, terms);
        self.refine(lights, terms, detail);
        let mut running = 0.0;
        self.running.clear();
        self.running.extend(self.weights.iter().map(|weight| {
            running += weight;
            running
        }));
        self.sum_up(lights, irradiance, terms);
    }

    fn look_at_chunks(&mut self, lights: &LightArrays, terms: &Terms) {
        self.parents.clear();
        self.weights.clear();
        for parent in &lights.parents {
            let numbers = terms.numbers(parent);
            self.weights.extend(self.weights_of(parent, &numbers));
            self.parents.push(numbers);
        }
    }

    /// c_j of eight lights (or chunks) from their numbers: luminance, and positive wherever a texel may
    /// contribute.
    #[inline(always)]
    fn weights_of(&self, chunk: &Chunk, numbers: &Numbers) -> Lane {
        let mut weight = [0.0f32; LANES];
        for k in 0..self.count {
            let own = if k == 0 {
                &numbers.wide
            } else {
                &numbers.terms[k]
            };
            let [y_r, y_g, y_b] = self.luminances[k];
            let [r, g, b] = &chunk.power;
            for i in 0..LANES {
                weight[i] += own[i] * (y_r * r[i] + y_g * g[i] + y_b * b[i]);
            }
        }
        for w in &mut weight {
            *w = larger(*w, 0.0);
        }
        weight
    }

    /// Replaces chunks by their lights.
    fn refine(&mut self, lights: &LightArrays, terms: &Terms, detail: Detail) {
        self.refined.clear();
        self.own.clear();
        self.own.resize(self.weights.len(), NONE);
        let least = match detail {
            Detail::All => 0.0,
            Detail::Highlights(_) if terms.gloss_term().is_none() => return,
            Detail::Highlights(share) => share * self.weights.iter().sum::<f32>(),
        };
        let gloss = terms.gloss_term();
        for chunk in 0..self.weights.len() {
            let (parent, lane) = (chunk / LANES, chunk % LANES);
            if self.weights[chunk] <= least {
                continue;
            }
            if let (Some(first), Detail::Highlights(_)) = (gloss, detail) {
                let mut highlight = 0.0;
                let [r, g, b] = &lights.parents[parent].power;
                for k in first..self.count {
                    let [y_r, y_g, y_b] = self.luminances[k];
                    let y = y_r * r[lane] + y_g * g[lane] + y_b * b[lane];
                    highlight += y * self.parents[parent].terms[k][lane];
                }
                if highlight <= least {
                    continue;
                }
            }
            let numbers = terms.numbers(&lights.chunks[chunk]);
            let weights = self.weights_of(&lights.chunks[chunk], &numbers);
            self.weights[chunk] = sum(&weights);
            self.own[chunk] = self.refined.len() as u32;
            self.refined.push((numbers, weights));
        }
    }

    /// U of both groups.
    fn sum_up(&mut self, lights: &LightArrays, irradiance: &Irradiance, terms: &Terms) {
        let mut sums: Sums = [[Vec3::ZERO; 2]; 4];
        // What is diffuse alone follows from the irradiance.
        if self.count > 1 || terms.coated() {
            let shown = (self.count, terms.coated());
            for (index, (parent, numbers)) in lights.parents.iter().zip(&self.parents).enumerate() {
                let group = usize::from(index >= lights.indirect);
                let mut kept = [0.0; LANES];
                for (kept, own) in kept.iter_mut().zip(&self.own[index * LANES..]) {
                    *kept = f32::from(u8::from(*own == NONE));
                }
                add(&mut sums, (group, shown), (parent, numbers), &kept);
            }
            for (chunk, &own) in self.own.iter().enumerate().filter(|(_, o)| **o != NONE) {
                let group = usize::from(chunk >= lights.indirect * LANES);
                let pair = (&lights.chunks[chunk], &self.refined[own as usize].0);
                add(&mut sums, (group, shown), pair, &[1.0; LANES]);
            }
        }
        let exact = match terms.diffuse_term() {
            true => irradiance.at(terms.normal),
            false => [Vec3::ZERO; 2],
        };
        for group in 0..2 {
            let mut unshadowed = Vec3::ZERO;
            for k in 0..self.count {
                let mut sum = sums[k][group];
                if k == 0 && terms.diffuse_term() {
                    // The share that enters a coating, times the irradiance of the map.
                    let plain = sums[3][group];
                    let through = |c: usize| match plain[c] > 0.0 {
                        true => sum[c] / plain[c],
                        false => 1.0,
                    };
                    sum = exact[group] * Vec3::from([0, 1, 2].map(through));
                }
                unshadowed += self.colours[k] * sum;
            }
            self.unshadowed[group] = unshadowed.max(Vec3::ZERO);
        }
    }

    /// Σ c_j.
    pub fn total(&self) -> f32 {
        self.running.last().copied().unwrap_or(0.0)
    }

    /// c_j of a chunk's lights.
    pub fn weights(&self, lights: &LightArrays, chunk: usize) -> Lane {
        match self.own[chunk] {
            NONE => {
                let numbers = &self.parents[chunk / LANES];
                let mut factor = [0.0f32; 3];
                for k in 0..self.count {
                    let own = if k == 0 {
                        &numbers.wide
                    } else {
                        &numbers.terms[k]
                    };
                    for (factor, y) in factor.iter_mut().zip(&self.luminances[k]) {
                        *factor += y * own[chunk % LANES];
                    }
                }
                let [r, g, b] = &lights.chunks[chunk].power;
                let mut weights = [0.0f32; LANES];
                for i in 0..LANES {
                    let weight = factor[0] * r[i] + factor[1] * g[i] + factor[2] * b[i];
                    weights[i] = larger(weight, 0.0);
                }
                weights
            }
            own => self.refined[own as usize].1,
        }
    }

    /// The unshadowed contribution of a light.
    pub fn contribution(&self, lights: &LightArrays, light: usize) -> Vec3 {
        let (chunk, i) = (light / LANES, light % LANES);
        let (numbers, lane) = match self.own[chunk] {
            NONE => (&self.parents[chunk / LANES], chunk % LANES),
            own => (&self.refined[own as usize].0, i),
        };
        let power = Vec3::from([0, 1, 2].map(|c| lights.chunks[chunk].power[c][i]));
        let scattered: Vec3 = (0..self.count)
            .map(|k| self.colours[k] * numbers.terms[k][lane])
            .sum();
        (scattered * power).max(Vec3::ZERO)
    }
}

/// Adds numbers times powers of as many terms as there are; under a coating, the last sum is that of
/// the plain cosines.
#[inline(always)]
fn add(
    sums: &mut Sums,
    (group, (count, coated)): (usize, (usize, bool)),
    (chunk, numbers): (&Chunk, &Numbers),
    kept: &Lane,
) {
    for (sum, numbers) in sums.iter_mut().zip(&numbers.terms[..count]) {
        weigh(&mut sum[group], (chunk, numbers), kept);
    }
    if coated {
        weigh(&mut sums[3][group], (chunk, &numbers.cosines), kept);
    }
}

#[inline(always)]
fn weigh(total: &mut Vec3, (chunk, numbers): (&Chunk, &Lane), kept: &Lane) {
    let mut all = [0.0; 3];
    for (all, power) in all.iter_mut().zip(&chunk.power) {
        let mut products = [0.0; LANES];
        for i in 0..LANES {
            products[i] = kept[i] * numbers[i] * power[i];
        }
        *all = sum(&products);
    }
    *total += Vec3::from(all);
}

#[inline(always)]
fn sum(lane: &Lane) -> f32 {
    let mut half = [0.0f32; 4];
    for i in 0..4 {
        half[i] = lane[i] + lane[i + 4];
    }
    (half[0] + half[2]) + (half[1] + half[3])
}
