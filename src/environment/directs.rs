//! EnvDirects (Wu 2024, section 3.3): lights on the emissive texels of a map, by importance sampling
//! with a masked neighbourhood, then k-means, then exclusion of what lies too far away.

use glam::DVec3;

use super::relaxation::{Cells, Item};
use super::texels::{Cluster, Texels, angle_rad};
use super::{Light, LightKind};
use crate::sample::Rng;

/// The steps, of which the ablation (Table 2) leaves some out.
#[derive(Clone, Copy, Debug)]
pub(super) struct Steps {
    /// Angle about a sample within which no other is drawn; 0 masks nothing.
    pub masking_rad: f64,
    /// Whether samples move to the centroids of their cells.
    pub k_means: bool,
    /// Texels farther than this from their light become non-emissive.
    pub exclusion_rad: f64,
}

/// The lights, and which of the emissive texels they stand for.
pub(super) struct Directs {
    pub lights: Vec<Light>,
    /// Parallel to the emissive texels; excluded ones are false.
    pub kept: Vec<bool>,
    /// The cell of each emissive texel; empty without lights.
    pub labels: Vec<u32>,
    pub rounds: usize,
}

/// Keys the random numbers of the draws.
const STREAM: u64 = 0x6469_7265_6374;
const MOST_ROUNDS: usize = 100;
/// How often lights that lost everything are put elsewhere.
const MOST_RESEEDS: usize = 4;
/// Moves of the centres, in texels, that are no longer worth a round.
const STILL: f64 = 0.02;

/// At most `count` lights in the map's space for the texels `emissive`.
pub(super) fn directs(
    texels: &Texels,
    emissive: &[u32],
    count: usize,
    seed: u64,
    steps: &Steps,
) -> Directs {
    let items: Vec<Item> = emissive
        .iter()
        .map(|&texel| {
            let direction = texels.direction(texel as usize);
            let moment = direction * texels.energy(texel as usize);
            Item { direction, moment }
        })
        .collect();
    let samples = draw(&items, count, steps.masking_rad, seed);
    if samples.is_empty() {
        return Directs {
            lights: Vec::new(),
            kept: vec![false; emissive.len()],
            labels: Vec::new(),
            rounds: 0,
        };
    }
    let chord = 2.0 * (0.5 * steps.exclusion_rad.min(std::f64::consts::PI)).sin();
    let mut cells = Cells::new(&items, samples).pulled_within(chord);
    let rounds = match steps.k_means {
        true => {
            let texel_rad = std::f64::consts::TAU / texels.width() as f64;
            relax(&mut cells, &items, STILL * texel_rad)
        }
        false => 0,
    };
    let kept: Vec<bool> = (0..items.len()).map(|i| cells.is_reached(i)).collect();
    let centres = cells.centres.clone();
    Directs {
        lights: lights(
            texels,
            emissive,
            &cells.labels,
            &kept,
            &centres,
            steps.k_means,
        ),
        kept,
        labels: cells.labels,
        rounds,
    }
}

/// k-means within reach; centres that lose all they stood for go to the brightest texel that no other keeps. Returns
/// the number of rounds.
fn relax(cells: &mut Cells, items: &[Item], still: f64) -> usize {
    let mut rounds = cells.relax(MOST_ROUNDS, still);
    for _ in 0..MOST_RESEEDS {
        let mut empty = vec![true; cells.centres.len()];
        let mut open = Vec::new();
        for (item, &label) in cells.labels.iter().enumerate() {
            match cells.is_reached(item) {
                true => empty[label as usize] = false,
                false => open.push(item),
            }
        }
        let energy = |item: &usize| items[*item].moment.length_squared();
        // Of equally bright ones the first.
        open.sort_by(|a, b| energy(b).total_cmp(&energy(a)).then(a.cmp(b)));
        let mut moved: Vec<(usize, DVec3)> = Vec::new();
        for cell in (0..empty.len()).filter(|&cell| empty[cell]) {
            let free = open.iter().map(|&item| items[item].direction);
            let mut free =
                free.filter(|d| moved.iter().all(|(_, taken)| !cells.reaches(*taken, *d)));
            match free.next() {
                Some(direction) => moved.push((cell, direction)),
                None => break,
            }
        }
        if moved.is_empty() {
            break;
        }
        cells.put(&moved);
        rounds += cells.relax(MOST_ROUNDS, still);
    }
    rounds
}

/// Draws directions by importance (luminance · solid angle) among what is not masked yet; fewer when
/// nothing is left.
fn draw(items: &[Item], count: usize, masking_rad: f64, seed: u64) -> Vec<DVec3> {
    let mut importance: Vec<f64> = items.iter().map(|i| i.moment.length()).collect();
    let mut running = vec![0.0; items.len()];
    let mut rng = Rng::new(seed, STREAM, 0, 0);
    let chord = 2.0 * (0.5 * masking_rad.min(std::f64::consts::PI)).sin();
    let mut samples = Vec::with_capacity(count);
    for _ in 0..count {
        let mut total = 0.0;
        for (sum, value) in running.iter_mut().zip(&importance) {
            total += value;
            *sum = total;
        }
        if total <= 0.0 {
            break;
        }
        let target = rng.next_f64() * total;
        let index = running.partition_point(|&sum| sum <= target);
        let sample = items[index.min(items.len() - 1)].direction;
        samples.push(sample);
        if masking_rad > 0.0 {
            for (value, item) in importance.iter_mut().zip(items) {
                if (item.direction - sample).length_squared() <= chord * chord {
                    *value = 0.0;
                }
            }
        }
    }
    samples
}

/// One light for each cell that kept anything. After k-means it stands at the centroid of what was
/// kept, otherwise where the sample is.
fn lights(
    texels: &Texels,
    emissive: &[u32],
    labels: &[u32],
    kept: &[bool],
    centres: &[DVec3],
    at_centroids: bool,
) -> Vec<Light> {
    let mut clusters = vec![Cluster::default(); centres.len()];
    let members = || {
        let all = emissive.iter().zip(labels).zip(kept);
        all.filter(|(_, kept)| **kept)
            .map(|((texel, label), _)| (*texel as usize, *label as usize))
    };
    for (texel, label) in members() {
        clusters[label].add(texels, texel);
    }
    let directions: Vec<Option<DVec3>> = clusters
        .iter()
        .zip(centres)
        .map(|(cluster, centre)| {
            let centroid = cluster.direction(texels)?;
            Some(if at_centroids { centroid } else { *centre })
        })
        .collect();
    let mut extents = vec![0.0f64; centres.len()];
    for (texel, label) in members() {
        if let Some(axis) = directions[label] {
            extents[label] = extents[label].max(angle_rad(axis, texels.direction(texel)));
        }
    }
    (0..centres.len())
        .filter_map(|i| {
            Some(Light {
                direction: directions[i]?.as_vec3(),
                power: clusters[i].power.to_array(),
                kind: LightKind::Direct,
                extent_rad: extents[i] as f32,
            })
        })
        .collect()
}
