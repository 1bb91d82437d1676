//! SD: spatial-directional clustering, a 6-D hierarchy of positions and scaled normals.
//!
//! Normals are multiplied by an eighth of the mean side of the points' bounding box and appended to the
//! positions; clusters are split in the middle of the widest of the six extents, down to one threshold for
//! all of them or to a minimum number of members. The threshold follows from the budget. The record of a
//! cluster is a random member.

use glam::Vec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::hierarchy::{Hierarchy, Measure, Split};
use super::members::{Bounds, COORDINATES, Member, pack};
use super::pick::{adjust, choice};
use super::representative::{Average, nearest_to_average, random_member};
use super::{FirstStage, Placement};
use crate::cache::{DistanceMetric, ShadingPoints};
use crate::entry::{About, Bias, Kind, Setting, parameters, words};
use crate::placement::FirstStageEntry;

/// The settings that `min_cluster_size = "best"` tries.
const SIZES: [usize; 6] = [1, 5, 10, 20, 50, 100];
/// What is used when "best" is placed without a search by error.
const USUAL_SIZE: usize = 10;

/// The smallest cluster that may still be split, exclusive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(untagged)]
pub enum MinClusterSize {
    /// So many points.
    Size(usize),
    /// The word `best`.
    Word(Best),
}

impl Setting for MinClusterSize {
    const KIND: Kind = Kind::WholeOr("best");
}

/// Chosen per scene by error, as the paper did.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Best {
    /// The size with the least error of those that are tried.
    Best,
}

words! {
    /// Which member becomes the record.
    pub enum Representative {
        /// Any, at random.
        Random = "random",
        /// The one nearest to the average of all.
        NearestAverage = "nearest-average",
    }
}

words! {
    /// What normals are multiplied with.
    pub enum NormalScale {
        /// Mean side of the points' bounding box / 8.
        MeanSide = "mean-side",
        /// Diagonal of the points' bounding box / 8.
        Diagonal = "diagonal",
    }
}

parameters! {
    /// LightSlice's clustering with a threshold on the widest 6-D extent.
    #[derive(Clone, Copy, Debug)]
    pub struct SpatialDirectional {
        /// Clusters of this many points or fewer are not split; best is the best of 1, 5, 10, 20, 50, 100
        /// by error.
        pub min_cluster_size: MinClusterSize = MinClusterSize::Word(Best::Best), Within(1.0, 100_000.0), "points";
        /// The member that becomes the record: a random one, or the nearest to the average as in VGC.
        pub representative: Representative = Representative::Random;
        /// Normals are scaled by an eighth of this measure of the points' box.
        pub normal_scale: NormalScale = NormalScale::MeanSide;
    }
}

/// Registry entry.
pub const ENTRY: FirstStageEntry = FirstStageEntry {
    about: About {
        id: "SD",
        module: crate::entry::head_comment!("sd.rs"),
        aliases: &["spatial-directional"],
        summary: "6-D clusters of positions and scaled normals, a random member of each",
        source: "Ou & Pellacini 2011 (LightSlice), section 4 and the authors' code; threshold and \
                 minimum size as in Wu & Shen 2023, section 1",
        bias: Bias::Consistent,
        version: 1,
        failures: &[
            "One threshold rules positions and normals: a half turn counts as a quarter of the \
             scene's mean extent whatever the scene's size.",
            "A small minimum cluster size spends records on distant surfaces, a large one blurs \
             distant details.",
            "A minimum size above half the points per record cannot reach the budget; the rest is \
             drawn uniformly at random.",
        ],
        parameters: SpatialDirectional::PARAMETERS,
    },
    build: |table| Ok(Box::new(SpatialDirectional::read(table)?)),
};

impl FirstStage for SpatialDirectional {
    /// The tree is grown once; the threshold is the size of the (count − 1)-th largest split, so
    /// that there are exactly `count` clusters. Where the minimum size or coincident points leave
    /// fewer, the rest is drawn uniformly from the other points.
    fn place(&self, points: &ShadingPoints, count: usize, seed: u64) -> Placement {
        let usable = match choice(points, count) {
            Ok(usable) => usable,
            Err(all) => return all,
        };
        let (least, mut notes) = self.least_members();
        let scale = self.scale(points, &usable);
        let mut tree = Hierarchy::new(pack(points, &usable, scale), Widest, least);
        tree.grow_to(count);
        let splits = tree.largest_first(count - 1);
        let threshold = splits
            .last()
            .map_or(f32::NAN, |&i| tree.nodes[i as usize].size);
        let clusters = tree.cut(&splits);
        let average = Average {
            metric: DistanceMetric::literal(points.diagonal, points.metres_per_unit),
            jitter: 0.1,
            normal_scale: scale,
        };
        let member = |&i: &u32| {
            let members = &tree.members[tree.nodes[i as usize].range()];
            match self.representative {
                Representative::Random => random_member(members, seed),
                Representative::NearestAverage => nearest_to_average(members, average, seed),
            }
        };
        let mut sites: Vec<u32> = clusters.par_iter().map(member).collect();
        if sites.len() < count {
            notes.push(format!(
                "clusters of more than {least} distinct points ran out at {}; the other {} records \
                 are uniformly random",
                sites.len(),
                count - sites.len()
            ));
        }
        let clusters = sites.len();
        adjust(&mut sites, &usable, count, seed);
        let found = vec![
            ("threshold", f64::from(threshold)),
            ("clusters", clusters as f64),
            ("min_cluster_size", least as f64),
        ];
        Placement {
            sites,
            found,
            notes,
            map: None,
        }
    }

    fn candidates(&self) -> Vec<Box<dyn FirstStage>> {
        if self.min_cluster_size != MinClusterSize::Word(Best::Best) {
            return Vec::new();
        }
        let with = |size| -> Box<dyn FirstStage> {
            Box::new(Self {
                min_cluster_size: MinClusterSize::Size(size),
                ..*self
            })
        };
        SIZES.into_iter().map(with).collect()
    }
}

impl SpatialDirectional {
    fn least_members(&self) -> (usize, Vec<String>) {
        match self.min_cluster_size {
            MinClusterSize::Size(size) => (size, Vec::new()),
            MinClusterSize::Word(Best::Best) => {
                let note = format!("min_cluster_size = best was not searched: {USUAL_SIZE} used");
                (USUAL_SIZE, vec![note])
            }
        }
    }

    fn scale(&self, points: &ShadingPoints, usable: &[u32]) -> f32 {
        let positions = usable.par_iter().map(|&i| points.position[i as usize]);
        let (low, high) = positions.map(|p| (p, p)).reduce(
            || (Vec3::INFINITY, Vec3::NEG_INFINITY),
            |a, b| (a.0.min(b.0), a.1.max(b.1)),
        );
        let side = (high - low).as_dvec3();
        let size = match self.normal_scale {
            NormalScale::MeanSide => side.element_sum() / 3.0,
            NormalScale::Diagonal => side.length(),
        };
        (size / 8.0) as f32
    }
}

/// The widest of the six extents and a plane through its middle.
struct Widest;

impl Measure for Widest {
    type Member = Member;
    type Summary = Bounds<8>;

    fn nothing(&self) -> Bounds<8> {
        Bounds::EMPTY
    }

    #[inline]
    fn add(&self, bounds: &mut Bounds<8>, member: &Member) {
        bounds.add(member.lanes());
    }

    fn join(&self, bounds: &mut Bounds<8>, other: &Bounds<8>) {
        bounds.join(other);
    }

    fn split(&self, bounds: &Bounds<8>, _count: usize) -> Split {
        let axis = bounds.widest(&COORDINATES);
        Split {
            size: bounds.extent(axis),
            axis,
            plane: Some(bounds.middle(axis)),
        }
    }
}
