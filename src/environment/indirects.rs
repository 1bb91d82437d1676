//! EnvIndirects (Wu 2024, section 3.4, eq. 3): a cut through a binary tree of directions, refined by
//! variance, extent and energy; with the variance alone it is the illumination cut of
//! Cheslack-Postava et al. 2008.

use std::f64::consts::PI;
use std::ops::Range;

use glam::DVec3;

use super::leaves::Leaf;
use super::texels::{Cluster, Texels, angle_rad};
use super::{Light, LightKind};

/// w_V, w_D and w_E of eq. 3.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights {
    pub variance: f64,
    pub extent: f64,
    pub energy: f64,
}

/// A node of the tree: a run of leaves. Children are made when the cut needs them.
struct Node {
    first: usize,
    end: usize,
    /// Σ solid angle · (luminance − mean)² over its leaves.
    variance: f64,
    /// Half-angle of a cone about the mean direction that holds its leaves; π for all directions.
    extent_rad: f64,
    energy: f64,
}

impl Node {
    fn new(leaves: &[Leaf], first: usize, end: usize) -> Self {
        let own = &leaves[first..end];
        let (mut angle, mut energy, mut axis) = (0.0, 0.0, DVec3::ZERO);
        for leaf in own {
            angle += leaf.solid_angle_sr;
            energy += leaf.sums.energy;
            axis += leaf.direction * leaf.solid_angle_sr;
        }
        let mean = energy / angle;
        let variance = own
            .iter()
            .map(|l| l.solid_angle_sr * (l.luminance() - mean).powi(2))
            .sum();
        Self {
            first,
            end,
            variance,
            extent_rad: cone_rad(own, axis / angle),
            energy,
        }
    }

    fn splits(&self) -> bool {
        self.end - self.first > 1
    }
}

/// Half-angle about the direction of `axis` that holds all leaves; π where they have no direction.
fn cone_rad(leaves: &[Leaf], axis: DVec3) -> f64 {
    if axis.length() < 1e-3 {
        return PI;
    }
    let axis = axis.normalize();
    let chord = leaves
        .iter()
        .map(|l| (l.direction - axis).length_squared())
        .fold(0.0, f64::max)
        .sqrt();
    2.0 * (0.5 * chord).min(1.0).asin()
}

/// At most `count` lights in the map's space for the leaves, none of them black.
pub(super) fn indirects(
    texels: &Texels,
    mut leaves: Vec<Leaf>,
    count: usize,
    weights: Weights,
) -> Vec<Light> {
    cut(&mut leaves, count, weights, 1)
        .into_iter()
        .filter_map(|run| light(texels, &leaves[run]))
        .collect()
}

/// At most `count` runs of the leaves, which are put in order for it: a cut through their tree. Each
/// round splits the best `at_once` nodes: 1 in the paper, more where that would take long.
pub(super) fn cut(
    leaves: &mut [Leaf],
    count: usize,
    weights: Weights,
    at_once: usize,
) -> Vec<Range<usize>> {
    if leaves.is_empty() || count == 0 {
        return Vec::new();
    }
    let mut cut = vec![Node::new(leaves, 0, leaves.len())];
    while cut.len() < count {
        let chosen = choose(&cut, weights, at_once.min(count - cut.len()));
        if chosen.is_empty() {
            break;
        }
        for index in chosen {
            let Node { first, end, .. } = cut[index];
            let middle = first + divide(&mut leaves[first..end]);
            cut[index] = Node::new(leaves, first, middle);
            cut.push(Node::new(leaves, middle, end));
        }
    }
    cut.iter().map(|node| node.first..node.end).collect()
}

/// The nodes, at most `most`, that split with the largest objective; each term is divided by its largest
/// value among those that split.
fn choose(cut: &[Node], weights: Weights, most: usize) -> Vec<usize> {
    let candidates = || cut.iter().enumerate().filter(|(_, node)| node.splits());
    let largest = |term: fn(&Node) -> f64| {
        let value = candidates().map(|(_, n)| term(n)).fold(0.0, f64::max);
        if value > 0.0 { 1.0 / value } else { 0.0 }
    };
    let by_variance = weights.variance * largest(|n| n.variance);
    let by_extent = weights.extent * largest(|n| n.extent_rad);
    let by_energy = weights.energy * largest(|n| n.energy);
    let objective = |node: &Node| {
        by_variance * node.variance + by_extent * node.extent_rad + by_energy * node.energy
    };
    // Of equal ones the first.
    let before = |a: &(f64, usize), b: &(f64, usize)| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1));
    let mut chosen: Vec<(f64, usize)> = candidates()
        .map(|(index, node)| (objective(node), index))
        .collect();
    if chosen.len() > most {
        chosen.select_nth_unstable_by(most, before);
        chosen.truncate(most);
    }
    chosen.sort_unstable_by(before);
    chosen.into_iter().map(|(_, index)| index).collect()
}

/// Orders leaves by the axis in which they spread most, and returns where the upper half begins.
fn divide(leaves: &mut [Leaf]) -> usize {
    let (mut low, mut high) = (DVec3::splat(2.0), DVec3::splat(-2.0));
    for leaf in leaves.iter() {
        low = low.min(leaf.turned);
        high = high.max(leaf.turned);
    }
    let axis = (high - low).max_position();
    let middle = leaves.len() / 2;
    // Ties are broken by the other coordinates, so that the order of the leaves does not matter.
    let key = |leaf: &Leaf| {
        let d = leaf.turned.to_array();
        [d[axis], d[(axis + 1) % 3], d[(axis + 2) % 3]]
    };
    leaves.select_nth_unstable_by(middle, |a, b| {
        let (a, b) = (key(a), key(b));
        a[0].total_cmp(&b[0])
            .then(a[1].total_cmp(&b[1]))
            .then(a[2].total_cmp(&b[2]))
    });
    middle
}

fn light(texels: &Texels, leaves: &[Leaf]) -> Option<Light> {
    let mut sums = Cluster::default();
    leaves.iter().for_each(|leaf| sums.merge(&leaf.sums));
    let axis = sums.direction(texels)?;
    let extent = leaves
        .iter()
        .filter(|leaf| leaf.sums.energy > 0.0)
        .map(|leaf| angle_rad(axis, leaf.direction))
        .fold(0.0, f64::max);
    Some(Light {
        direction: axis.as_vec3(),
        power: sums.power.to_array(),
        kind: LightKind::Indirect,
        extent_rad: extent as f32,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::leaves::leaves;
    use crate::environment::{Environment, EnvironmentOptions};
    use crate::image::Image;

    const PAPER: Weights = Weights {
        variance: 1.0,
        extent: 5.0,
        energy: 1.0,
    };

    fn map(value: impl Fn(usize, usize) -> f32) -> Environment {
        let mut image = Image::new(128, 64);
        for (i, pixel) in image.pixels.iter_mut().enumerate() {
            *pixel = [value(i % 128, i / 128); 3];
        }
        Environment::from_image(&image, &EnvironmentOptions::default()).expect("map")
    }

    fn lights_of(map: &Environment, count: usize, weights: Weights) -> Vec<Light> {
        let texels = Texels::new(map);
        let leaves = leaves(&texels, 8192, &vec![false; texels.luminance.len()], 0);
        indirects(&texels, leaves, count, weights)
    }

    #[test]
    fn a_constant_map_is_divided_evenly() {
        let lights = lights_of(&map(|_, _| 1.0), 16, PAPER);
        assert_eq!(lights.len(), 16);
        let each = 4.0 * PI / 16.0;
        for light in &lights {
            assert!(
                (light.power[0] / each - 1.0).abs() < 0.05,
                "{:?}",
                light.power
            );
        }
    }

    #[test]
    fn extent_and_energy_keep_homogeneous_regions_divided() {
        // A textured half and a plain half: by variance alone the plain half stays whole.
        let map = map(|x, y| {
            if y < 32 {
                1.0
            } else {
                ((x / 8 + y / 8) % 2) as f32
            }
        });
        let upper = |weights: Weights| {
            let lights = lights_of(&map, 24, weights);
            lights.iter().filter(|l| l.direction.y > 0.1).count()
        };
        let variance_only = Weights {
            variance: 1.0,
            extent: 0.0,
            energy: 0.0,
        };
        assert_eq!(upper(variance_only), 1);
        assert!(upper(PAPER) >= 8, "{}", upper(PAPER));
    }

    #[test]
    fn there_are_no_more_lights_than_leaves_and_no_black_ones() {
        let black = map(|_, _| 0.0);
        assert!(lights_of(&black, 8, PAPER).is_empty());
        let spot = map(|x, y| if (x, y) == (5, 7) { 1.0 } else { 0.0 });
        let lights = lights_of(&spot, 64, PAPER);
        assert_eq!(lights.len(), 1);
        let texel = spot.texel_direction(5, 7);
        assert!((lights[0].direction - texel).length() < 1e-6);
    }
}
