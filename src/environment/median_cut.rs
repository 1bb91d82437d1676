//! Median cut (Debevec 2005): regions of equal energy.

use super::regions::{Cutting, Region, cut_regions};
use super::texels::Texels;
use super::{Environment, EnvironmentSampler, LightSampler, LightSet};
use crate::entry::{About, Bias, check_keys};
use crate::environment::SamplerEntry;

/// The registry's entry.
pub const ENTRY: SamplerEntry = SamplerEntry {
    about: About {
        id: "median-cut",
        module: crate::entry::head_comment!("median_cut.rs"),
        aliases: &["mc"],
        summary: "rectangles of equal energy, halved along their longer side",
        source: "Debevec 2005",
        bias: Bias::Consistent,
        version: 2,
        failures: &[
            "a region that holds a bright source and much else puts its light beside the source",
            "rectangles end at the seam of the map",
        ],
        parameters: &[],
    },
    build: |table| {
        check_keys(table, &[])?;
        Ok(EnvironmentSampler::Lights(Box::new(MedianCut)))
    },
};

struct MedianCut;

/// *differs:* counts between powers of two halve the regions of most energy in the last pass; the
/// centroid is taken on the sphere.
impl LightSampler for MedianCut {
    fn lights(&self, map: &Environment, count: usize, _seed: u64) -> LightSet {
        let texels = Texels::new(map);
        cut_regions(&texels, count, self).turned(map.to_world())
    }
}

impl Cutting for MedianCut {
    /// Halves the energy along the side that is longer on the sphere.
    fn cut(&self, texels: &Texels, region: &Region) -> Option<[Region; 2]> {
        let middle = (region.y.start + region.y.end) / 2;
        let width = region.x.len() as f64 * texels.rows[middle.min(texels.height() - 1)].sin;
        // A texel is 2π / W wide and π / H high.
        let aspect = 2.0 * texels.height() as f64 / texels.width() as f64;
        let mut along_x = width * aspect > region.y.len() as f64;
        if region.x.len() < 2 {
            along_x = false;
        } else if region.y.len() < 2 {
            along_x = true;
        }
        let energies = region.energies(texels, along_x);
        let position = balanced(&energies)?;
        Some(region.halves(along_x, position))
    }
}

/// Where to cut so that both sums are as equal as possible, both parts with at least one entry; the
/// middle of zeros. `None` for fewer than two entries.
fn balanced(energies: &[f64]) -> Option<usize> {
    if energies.len() < 2 {
        return None;
    }
    let total: f64 = energies.iter().sum();
    if total <= 0.0 {
        return Some(energies.len() / 2);
    }
    let mut sum = 0.0;
    let mut best = (1, f64::INFINITY);
    for (index, energy) in energies[..energies.len() - 1].iter().enumerate() {
        sum += energy;
        let imbalance = (2.0 * sum - total).abs();
        let centrality = |cut: usize| (2 * cut).abs_diff(energies.len());
        if imbalance < best.1 || imbalance == best.1 && centrality(index + 1) < centrality(best.0) {
            best = (index + 1, imbalance);
        }
    }
    Some(best.0)
}

#[cfg(test)]
mod tests {
    use super::balanced;

    #[test]
    fn cuts_balance_and_leave_no_side_empty() {
        assert_eq!(balanced(&[1.0]), None);
        assert_eq!(balanced(&[0.0; 8]), Some(4));
        assert_eq!(balanced(&[1.0; 8]), Some(4));
        assert_eq!(balanced(&[9.0, 1.0, 1.0]), Some(1));
        assert_eq!(balanced(&[1.0, 1.0, 9.0]), Some(2));
        assert_eq!(balanced(&[0.0, 0.0, 5.0, 0.0, 0.0, 0.0]), Some(3));
    }
}
