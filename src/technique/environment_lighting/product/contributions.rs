//! Unshadowed contributions of all lights at a shading point.
//!
//! Chunks of 64 neighbouring lights are looked at first, as if each were one light; where such a chunk
//! makes a highlight, its eight parts take its place, and where one of these does, its lights. A surface
//! scatters by up to three terms, each a colour times a number a light: the loops work on the numbers of
//! eight lights at once, in one register where the processor has such, with the same results.

use glam::Vec3;
use macro_rules_attribute::apply;

use super::irradiance::Irradiance;
use super::lights::{Chunk, LANES, LEVELS, Lane, LightArrays, larger};
use super::terms::{Numbers, Terms};

use crate::instructions::compiled_for_avx2;

/// The uppermost level of chunks.
const TOP: usize = LEVELS - 1;
const _: () = assert!(TOP == 2, "chunks, chunks of chunks and lights");

/// Contributions at one point; reused from point to point.
#[derive(Default)]
pub(super) struct Contributions {
    /// Of the chunks of the uppermost level.
    top: Vec<Numbers>,
    /// Σ c_j of every lane of the uppermost level.
    weights: Vec<f32>,
    /// Running sums of the weights.
    pub running: Vec<f32>,
    /// Chunks of the lower levels that are looked at themselves.
    opened: [Vec<Opened>; TOP],
    /// The place of a chunk in `opened`, or [`NONE`].
    own: [Vec<u32>; TOP],
    /// U of both groups.
    pub unshadowed: [Vec3; 2],
    colours: [Vec3; 3],
    luminances: [[f32; 3]; 3],
    count: usize,
}

struct Opened {
    chunk: usize,
    numbers: Numbers,
    /// Σ c_j of every lane.
    weights: Lane,
}

const NONE: u32 = u32::MAX;
const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// Which lights are looked at one by one.
#[derive(Clone, Copy)]
pub(super) enum Detail {
    /// Those of chunks whose spread takes this share of all light, or more, from a highlight.
    Highlights(f32),
    All,
}

/// Which chunks are opened.
#[derive(Clone, Copy)]
struct Limits {
    /// Least weight.
    weight: f32,
    /// The first term of a highlight and the squared roughness, by which what the lights' spread takes
    /// from the highlight must reach the least weight; `None` asks for none.
    gloss: Option<(usize, f32)>,
}

/// Which terms are summed.
#[derive(Clone, Copy)]
struct Summed {
    count: usize,
    /// Whether the diffuse one lies under a coating.
    coated: bool,
}

/// Power of a term by group and channel.
type Sums = [[Vec3; 2]; 4];

/// All of [`Contributions::evaluate`] is compiled into this, for each kind of processor.
#[apply(compiled_for_avx2)]
fn evaluate(
    contributions: &mut Contributions,
    lights: &LightArrays,
    irradiance: &Irradiance,
    terms: &Terms,
    detail: Detail,
) {
    contributions.evaluate_inlined(lights, irradiance, terms, detail);
}

impl Contributions {
    /// Evaluates the lights.
    pub fn evaluate(
        &mut self,
        lights: &LightArrays,
        irradiance: &Irradiance,
        terms: &Terms,
        detail: Detail,
    ) {
        evaluate(self, lights, irradiance, terms, detail);
    }

    #[inline(always)]
    fn evaluate_inlined(
        &mut self,
        lights: &LightArrays,
        irradiance: &Irradiance,
        terms: &Terms,
        detail: Detail,
    ) {
        (self.colours, self.count) = (terms.colours, terms.count);
        self.luminances = terms
            .colours
            .map(|colour| [0, 1, 2].map(|c| LUMINANCE[c] * colour[c]));
        self.look_at_top(lights, terms);
        self.open(lights, terms, detail);
        let mut running = 0.0;
        self.running.clear();
        self.running.extend(self.weights.iter().map(|weight| {
            running += weight;
            running
        }));
        self.sum_up(lights, irradiance, terms);
    }

    #[inline(always)]
    fn look_at_top(&mut self, lights: &LightArrays, terms: &Terms) {
        self.top.clear();
        self.weights.clear();
        for chunk in &lights.levels[TOP] {
            let numbers = terms.numbers(chunk);
            self.weights.extend(self.weights_of(chunk, &numbers));
            self.top.push(numbers);
        }
        for level in 0..TOP {
            self.opened[level].clear();
            self.own[level].clear();
            self.own[level].resize(lights.levels[level].len(), NONE);
        }
    }

    /// c_j of eight lights (or chunks) from their numbers: luminance, and positive wherever a texel may
    /// contribute.
    #[inline(always)]
    fn weights_of(&self, chunk: &Chunk, numbers: &Numbers) -> Lane {
        let mut weight = [0.0f32; LANES];
        for k in 0..self.count {
            let own = numbers.choosing(k);
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

    /// Replaces chunks by their parts, level by level.
    #[inline(always)]
    fn open(&mut self, lights: &LightArrays, terms: &Terms, detail: Detail) {
        let gloss = terms.gloss_term();
        let limits = match detail {
            Detail::All => Limits {
                weight: 0.0,
                gloss: None,
            },
            Detail::Highlights(_) if gloss.is_none() => return,
            Detail::Highlights(share) => Limits {
                weight: share * self.weights.iter().sum::<f32>(),
                gloss,
            },
        };
        for at in 0..self.weights.len() {
            let (chunk, lane) = (at / LANES, at % LANES);
            let (whole, numbers) = (&lights.levels[TOP][chunk], &self.top[chunk]);
            if self.reaches(limits, whole, numbers, lane, self.weights[at]) {
                self.weights[at] = self.open_chunk(lights, terms, at, limits);
            }
        }
    }

    /// Looks at the lanes of a chunk of chunks, and at the lights of those that are worth it. The sum of
    /// their weights.
    #[inline(always)]
    fn open_chunk(
        &mut self,
        lights: &LightArrays,
        terms: &Terms,
        at: usize,
        limits: Limits,
    ) -> f32 {
        let chunk = &lights.levels[1][at];
        let numbers = terms.numbers(chunk);
        let mut weights = self.weights_of(chunk, &numbers);
        for (lane, weight) in weights.iter_mut().enumerate() {
            if self.reaches(limits, chunk, &numbers, lane, *weight) {
                let part = at * LANES + lane;
                let lights = &lights.levels[0][part];
                let numbers = terms.numbers(lights);
                let own = self.weights_of(lights, &numbers);
                *weight = self.keep(0, part, numbers, own);
            }
        }
        self.keep(1, at, numbers, weights)
    }

    /// Takes a chunk of a lower level among those that are looked at themselves. The sum of its weights.
    #[inline(always)]
    fn keep(&mut self, level: usize, chunk: usize, numbers: Numbers, weights: Lane) -> f32 {
        self.own[level][chunk] = self.opened[level].len() as u32;
        self.opened[level].push(Opened {
            chunk,
            numbers,
            weights,
        });
        sum(&weights)
    }

    /// Whether a lane of a chunk, of this weight, is to be replaced by its parts.
    #[inline(always)]
    fn reaches(
        &self,
        limits: Limits,
        chunk: &Chunk,
        numbers: &Numbers,
        lane: usize,
        weight: f32,
    ) -> bool {
        if weight <= limits.weight {
            return false;
        }
        let Some((first, alpha2)) = limits.gloss else {
            return true;
        };
        let [r, g, b] = &chunk.power;
        let mut highlight = 0.0;
        for k in first..self.count {
            let [y_r, y_g, y_b] = self.luminances[k];
            let y = y_r * r[lane] + y_g * g[lane] + y_b * b[lane];
            highlight += y * numbers.terms[k][lane];
        }
        let width = chunk.widening[lane];
        highlight * width > limits.weight * (alpha2 + width)
    }

    /// U of both groups.
    #[inline(always)]
    fn sum_up(&mut self, lights: &LightArrays, irradiance: &Irradiance, terms: &Terms) {
        let mut sums: Sums = [[Vec3::ZERO; 2]; 4];
        // What is diffuse alone follows from the irradiance.
        if self.count > 1 || terms.coated() {
            let summed = Summed {
                count: self.count,
                coated: terms.coated(),
            };
            for (index, numbers) in self.top.iter().enumerate() {
                let (group, kept) = (lights.group(TOP, index), self.kept(TOP, index));
                let chunk = &lights.levels[TOP][index];
                add(&mut sums, group, summed, chunk, numbers, &kept);
            }
            for (level, opened) in self.opened.iter().enumerate() {
                for own in opened {
                    let group = lights.group(level, own.chunk);
                    let chunk = &lights.levels[level][own.chunk];
                    let kept = self.kept(level, own.chunk);
                    add(&mut sums, group, summed, chunk, &own.numbers, &kept);
                }
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

    /// 1 for the lanes of a chunk that their parts do not replace, 0 for the others.
    #[inline(always)]
    fn kept(&self, level: usize, chunk: usize) -> Lane {
        if level == 0 {
            return [1.0; LANES];
        }
        let parts = &self.own[level - 1][chunk * LANES..][..LANES];
        std::array::from_fn(|i| f32::from(u8::from(parts[i] == NONE)))
    }

    /// Σ c_j.
    pub fn total(&self) -> f32 {
        self.running.last().copied().unwrap_or(0.0)
    }

    /// Σ c_j of the lanes of a chunk of a lower level; c_j of lights at level 0.
    pub fn weights(&self, lights: &LightArrays, level: usize, chunk: usize) -> Lane {
        if let Some(own) = self.opened[level].get(self.own[level][chunk] as usize) {
            return own.weights;
        }
        let (numbers, lane) = self.above(level, chunk);
        let mut factor = [0.0f32; 3];
        for k in 0..self.count {
            let own = numbers.choosing(k)[lane];
            for (factor, y) in factor.iter_mut().zip(&self.luminances[k]) {
                *factor += y * own;
            }
        }
        let [r, g, b] = &lights.levels[level][chunk].power;
        let mut weights = [0.0f32; LANES];
        for i in 0..LANES {
            let weight = factor[0] * r[i] + factor[1] * g[i] + factor[2] * b[i];
            weights[i] = larger(weight, 0.0);
        }
        weights
    }

    /// The numbers of the lane that stands for a chunk.
    fn above(&self, level: usize, chunk: usize) -> (&Numbers, usize) {
        let (parent, lane) = (chunk / LANES, chunk % LANES);
        if level + 1 == TOP {
            return (&self.top[parent], lane);
        }
        match self.opened[level + 1].get(self.own[level + 1][parent] as usize) {
            Some(own) => (&own.numbers, lane),
            None => self.above(level + 1, parent),
        }
    }

    /// The unshadowed contribution of a light, its cosine not that of its chunk.
    pub fn contribution(&self, lights: &LightArrays, terms: &Terms, light: usize) -> Vec3 {
        let (chunk, i) = (light / LANES, light % LANES);
        let (numbers, lane) = match self.opened[0].get(self.own[0][chunk] as usize) {
            Some(own) => (&own.numbers, i),
            None => self.above(0, chunk),
        };
        let own = &lights.levels[0][chunk];
        let power = Vec3::from([0, 1, 2].map(|c| own.power[c][i]));
        let mut scattered: Vec3 = (0..self.count)
            .map(|k| self.colours[k] * numbers.terms[k][lane])
            .sum();
        if terms.diffuse_term() {
            let (first, cosine) = (numbers.terms[0][lane], numbers.cosines[lane]);
            // A chunk below the horizon tells nothing of its lights above it, which enter a coating
            // hardly, and else as all light.
            let through = match cosine > 0.0 {
                true => first / cosine,
                false => f32::from(u8::from(!terms.coated())),
            };
            scattered += self.colours[0] * (through * own.cosine(i, terms.normal) - first);
        }
        (scattered * power).max(Vec3::ZERO)
    }
}

/// Adds numbers times powers of as many terms as there are; under a coating, the last sum is that of
/// the plain cosines.
#[inline(always)]
fn add(
    sums: &mut Sums,
    group: usize,
    summed: Summed,
    chunk: &Chunk,
    numbers: &Numbers,
    kept: &Lane,
) {
    for (sum, numbers) in sums.iter_mut().zip(&numbers.terms[..summed.count]) {
        weigh(&mut sum[group], chunk, numbers, kept);
    }
    if summed.coated {
        weigh(&mut sums[3][group], chunk, &numbers.cosines, kept);
    }
}

#[inline(always)]
fn weigh(total: &mut Vec3, chunk: &Chunk, numbers: &Lane, kept: &Lane) {
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
