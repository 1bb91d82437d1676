//! Relaxation of Voronoi cells with insertion into the strongest (Kollig & Keller 2003).

use super::blocks::Blocks;
use super::relaxation::Cells;
use super::texels::Texels;
use super::{Environment, EnvironmentSampler, LightSampler, LightSet};
use crate::entry::{About, Bias, parameters};
use crate::environment::SamplerEntry;

/// The registry's entry.
pub const ENTRY: SamplerEntry = SamplerEntry {
    about: About {
        id: "kollig-keller",
        module: crate::entry::head_comment!("kollig_keller.rs"),
        aliases: &["kk"],
        summary: "Voronoi cells relaxed after each light added to the strongest cell",
        source: "Kollig & Keller 2003 (reconstruction: start and insertion are not established)",
        bias: Bias::Consistent,
        version: 2,
        failures: &[
            "a cell that holds a bright source and much else puts its light beside the source",
        ],
        parameters: Parameters::PARAMETERS,
    },
    build: |table| {
        Ok(EnvironmentSampler::Lights(Box::new(KolligKeller(
            Parameters::read(table)?,
        ))))
    },
};

parameters! {
    #[derive(Clone, Copy, Debug)]
    struct Parameters {
        /// Most relaxation rounds after each insertion.
        rounds: usize = 50, AtLeast(0.0);
    }
}

/// Most blocks that are relaxed: each insertion looks at all of them.
const MOST_BLOCKS: usize = 256 * 128;

struct KolligKeller(Parameters);

/// *differs:* starts at the energy centroid of the map and inserts at the brightest item of the
/// strongest cell. Maps of more texels than 256×128 are relaxed in blocks, with exact sums.
impl LightSampler for KolligKeller {
    fn lights(&self, map: &Environment, count: usize, _seed: u64) -> LightSet {
        let texels = Texels::new(map);
        let blocks = Blocks::new(&texels, MOST_BLOCKS);
        let (items, energies) = blocks.items(&texels);
        let total = blocks.total();
        let Some(first) = total.direction(&texels).filter(|_| count > 0) else {
            return LightSet::default();
        };
        let mut cells = Cells::new(&items, vec![first]);
        while cells.centres.len() < count.min(items.len()) {
            let Some(centre) = strongest(&cells, &energies) else {
                break;
            };
            cells.insert(items[centre].direction);
            cells.relax(self.0.rounds, 0.0);
        }
        blocks
            .light_set(&texels, cells.centres.len(), &cells.labels)
            .turned(map.to_world())
    }
}

/// The item with the most energy in the cell of most energy, among cells that hold several items.
fn strongest(cells: &Cells, energies: &[f64]) -> Option<usize> {
    let mut sums = vec![(0.0f64, 0u32); cells.centres.len()];
    for (&label, &energy) in cells.labels.iter().zip(energies) {
        sums[label as usize].0 += energy;
        sums[label as usize].1 += 1;
    }
    let mut best: Option<(usize, f64)> = None;
    for (cell, &(energy, items)) in sums.iter().enumerate() {
        if items > 1 && energy > best.map_or(0.0, |b| b.1) {
            best = Some((cell, energy));
        }
    }
    let (cell, _) = best?;
    let centre = cells.centres[cell];
    let mut chosen: Option<(usize, f64)> = None;
    for (index, _) in cells
        .labels
        .iter()
        .enumerate()
        .filter(|(_, l)| **l as usize == cell)
    {
        let apart = cells.direction(index) != centre;
        if apart && energies[index] > chosen.map_or(0.0, |c| c.1) {
            chosen = Some((index, energies[index]));
        }
    }
    chosen.map(|(index, _)| index)
}
