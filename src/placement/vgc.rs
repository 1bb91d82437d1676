//! VGC: view-guided clustering.
//!
//! Shading points are split in space until a cluster's longest side is at most σ_s, then by normals until
//! their spread is at most σ_a. Both thresholds grow with the depth of the cluster, from σ at the nearest
//! to α σ at the farthest point, `α = 1 + Γ (d_max − d_min)`, so that distant surfaces get fewer records.
//! σ_a is given; σ_s follows from the budget. The record of a cluster is the member nearest to its jittered
//! mean position and mean normal.
//!
//! *differs:* Γ is per metre. Where a scene does not declare the length of its unit, its diagonal is taken for
//! 10 m, so that Γ is 2 per diagonal and the unit of the file does not matter.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::cones::{Cones, Thresholds};
use super::cut::{Angular, Cluster, Cut, split_largest};
use super::growth::Growth;
use super::hierarchy::{Hierarchy, Measure, Split};
use super::members::{Bounds, Member, POSITION, Spot, complete, spots};
use super::pick::{adjust, choice};
use super::representative::Average;
use super::{FirstStage, Placement};
use crate::cache::{DistanceMetric, ShadingPoints};
use crate::entry::{About, Bias, Kind, Setting, parameters, words};
use crate::placement::FirstStageEntry;

/// The suggested σ_a, degrees, for numbers of records.
const SUGGESTED: [(f64, f64); 5] = [
    (25e3, 25.0),
    (40e3, 25.0),
    (50e3, 22.0),
    (80e3, 18.0),
    (120e3, 15.0),
];
/// σ_a grows by this factor until the budget is feasible.
const RAISE: f32 = 1.25;

/// σ_a by number or by the suggested rule.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(untagged)]
pub enum Angle {
    /// The angle itself.
    Degrees(f64),
    /// The word `auto`.
    Word(Auto),
}

impl Setting for Angle {
    const KIND: Kind = Kind::NumberOr("auto");
}

/// The suggested rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Auto {
    /// From the number of records, as the paper's table suggests.
    Auto,
}

words! {
    /// Where clusters are split.
    pub enum Plane {
        /// In the middle of the tight box.
        Midpoint = "midpoint",
        /// At the median member.
        Median = "median",
    }
}

parameters! {
    /// Clusters that are bounded in space and in direction, by thresholds that grow with depth.
    #[derive(Clone, Copy, Debug)]
    pub struct ViewGuided {
        /// σ_a; auto is 15 from 120K records, 18 at 80K, 22 at 50K, 25 from 40K to 25K, and more for
        /// fewer, up to 45.
        pub angle_deg: Angle = Angle::Word(Auto::Auto), AboveUpTo(0.0, 180.0), "°";
        /// Γ: growth of the thresholds with the depth range.
        pub gamma: f64 = 0.2, Within(0.0, 1000.0), "1/m";
        /// Eq. 1 as printed, with (1 − α): thresholds shrink with depth.
        pub literal_sign: bool = false;
        /// Where clusters are split: in the middle of the tight box, or at the median.
        pub split: Plane = Plane::Midpoint;
        /// κ of λ = 0.5·L·κ in eq. 2; without it λ = 0.5 / L in metres.
        pub lambda_kappa: Option<f64> = None, Within(0.0, 1000.0);
        /// Largest move of a cluster's average position.
        pub jitter: f64 = 0.1, Within(0.0, 1.0), "box sides";
    }
}

/// Registry entry.
pub const ENTRY: FirstStageEntry = FirstStageEntry {
    about: About {
        id: "VGC",
        module: crate::entry::head_comment!("vgc.rs"),
        aliases: &["view-guided", "view-guided-clustering"],
        summary: "clusters by position, then by normal, with thresholds that grow with depth",
        source: "Wu & Shen 2023, section 3.1, eq. 1 and 2. Readings: the sign of (α − 1), \
                 lengths in metres, normal cones instead of (θ, φ) boxes, mean depth of a node, \
                 midpoint splits",
        bias: Bias::Consistent,
        version: 1,
        failures: &[
            "Knows nothing of shading: shadow edges on flat ground get no records of their own.",
            "Open scenes with a large depth range want about twice the suggested angle.",
            "A scene with a wrong metres_per_unit gets wrong thresholds and about half more error; \
             one without takes its diagonal for 10 m.",
        ],
        parameters: ViewGuided::PARAMETERS,
    },
    build: |table| Ok(Box::new(ViewGuided::read(table)?)),
};

impl FirstStage for ViewGuided {
    /// One hierarchy is grown; σ_s is searched over its splits with memoised angular counts, down to
    /// the smallest with at most `count` clusters. Missing ones come from splitting the
    /// clusters with the most members. If one spatial cluster already gives too many, σ_a is
    /// raised by factors of 1.25 and a note says so; at 180° surplus records leave at random.
    fn place(&self, points: &ShadingPoints, count: usize, seed: u64) -> Placement {
        let usable = match choice(points, count) {
            Ok(usable) => usable,
            Err(all) => return all,
        };
        let growth = self.growth(points, &usable);
        let measure = RelativeSize {
            growth,
            midpoint: self.split == Plane::Midpoint,
        };
        let mut tree = Hierarchy::new(spots(points, &usable), measure, 1);
        tree.grow_to(count);
        let asked = self.asked_angle_deg(count);
        let mut thresholds = Thresholds {
            growth,
            angle_rad: asked.to_radians(),
        };
        let angular = |thresholds| Angular {
            points,
            cones: Cones::new(thresholds),
            average: Average {
                metric: self.metric(points),
                jitter: self.jitter as f32,
                normal_scale: 1.0,
            },
            seed,
        };
        let mut cut = Cut::find(&tree, angular(thresholds), count);
        while cut.clusters > count && thresholds.angle_rad < std::f32::consts::PI {
            thresholds.angle_rad = (thresholds.angle_rad * RAISE).min(std::f32::consts::PI);
            cut = Cut::find(&tree, angular(thresholds), count);
        }
        let angle_deg = thresholds.angle_rad.to_degrees();
        let mut notes: Vec<String> = self.note_on_unit(points).into_iter().collect();
        if thresholds.angle_rad > asked.to_radians() {
            notes.push(format!(
                "σ_a = {asked:.1}° gives more than {count} clusters at any σ_s: raised to \
                 {angle_deg:.1}°"
            ));
        }
        let found = vec![
            ("sigma_a_deg", f64::from(angle_deg)),
            ("sigma_s", f64::from(cut.size)),
            ("alpha", f64::from(growth.alpha)),
            ("spatial_clusters", cut.nodes.len() as f64),
            ("clusters", cut.clusters as f64),
        ];
        let angular = angular(thresholds);
        let mut clusters = cut.clusters_of(&mut tree, angular);
        split_largest(&mut tree.members, &mut clusters, count);
        let record = |members: &mut Vec<Member>, cluster: Cluster| {
            cluster.record.unwrap_or_else(|| {
                members.clear();
                complete(points, &tree.members[cluster.range], members);
                angular.record(members)
            })
        };
        let clusters = clusters.into_par_iter();
        let mut sites: Vec<u32> = clusters.map_init(Vec::new, record).collect();
        if adjust(&mut sites, &usable, count, seed) < 0 {
            notes.push("even one spatial cluster splits too often: records left at random".into());
        }
        Placement {
            sites,
            found,
            notes,
            map: None,
        }
    }
}

/// The longest side of the members' box over the growth of σ_s at their mean depth.
struct RelativeSize {
    growth: Growth,
    midpoint: bool,
}

impl Measure for RelativeSize {
    type Member = Spot;
    /// The box, and the sum of the depths.
    type Summary = (Bounds<4>, f64);

    fn nothing(&self) -> Self::Summary {
        (Bounds::EMPTY, 0.0)
    }

    #[inline]
    fn add(&self, (bounds, depth): &mut Self::Summary, spot: &Spot) {
        bounds.add(&spot.lanes);
        *depth += f64::from(spot.lanes[3]);
    }

    fn join(&self, (bounds, depth): &mut Self::Summary, other: &Self::Summary) {
        bounds.join(&other.0);
        *depth += other.1;
    }

    fn split(&self, (bounds, depth): &Self::Summary, count: usize) -> Split {
        let mean_depth = (depth / count as f64) as f32;
        let axis = bounds.widest(&POSITION);
        Split {
            size: bounds.extent(axis) / self.growth.factor(mean_depth),
            axis,
            plane: self.midpoint.then(|| bounds.middle(axis)),
        }
    }
}

impl ViewGuided {
    fn growth(&self, points: &ShadingPoints, usable: &[u32]) -> Growth {
        let depths = usable.par_iter().map(|&i| points.depth[i as usize]);
        let (nearest, farthest) = depths.map(|depth| (depth, depth)).reduce(
            || (f32::INFINITY, f32::NEG_INFINITY),
            |a, b| (a.0.min(b.0), a.1.max(b.1)),
        );
        let gamma = self.gamma as f32;
        let mut growth = Growth::new(nearest, farthest, gamma, points.metres_per_unit);
        growth.literal_sign = self.literal_sign;
        growth
    }

    /// What Γ is in a scene whose unit is not declared.
    fn note_on_unit(&self, points: &ShadingPoints) -> Option<String> {
        let metres = points.metres_per_unit;
        points.unit_is_assumed.then(|| {
            format!(
                "no metres_per_unit is declared: Γ = {:.3} per diagonal, which is taken for {:.0} m",
                self.gamma as f32 * metres * points.diagonal,
                metres * points.diagonal
            )
        })
    }

    /// *differs:* the paper sets the angle by the total budget; a placement knows only its own
    /// share of it.
    fn asked_angle_deg(&self, count: usize) -> f32 {
        match self.angle_deg {
            Angle::Degrees(degrees) => degrees as f32,
            Angle::Word(Auto::Auto) => suggested_angle_deg(count as f64) as f32,
        }
    }

    fn metric(&self, points: &ShadingPoints) -> DistanceMetric {
        match self.lambda_kappa {
            Some(kappa) => DistanceMetric::scaled(kappa as f32, points.diagonal),
            None => DistanceMetric::literal(points.diagonal, points.metres_per_unit),
        }
    }
}

/// The paper's σ_a for a number of records, linear between its values. *differs:* below 25K records,
/// where the paper gives none, the angle grows with the logarithm of the count as it does between
/// 40K and 120K, up to 45°: few records cannot pay for narrow cones.
fn suggested_angle_deg(count: f64) -> f64 {
    let (least, widest) = SUGGESTED[0];
    if count <= least {
        let per_fold = 10.0 / 3.0f64.ln();
        return (widest + per_fold * (least / count.max(1.0)).ln()).min(45.0);
    }
    for pair in SUGGESTED.windows(2) {
        let ((low, from), (high, to)) = (pair[0], pair[1]);
        if count <= high {
            return from + (to - from) * (count - low) / (high - low);
        }
    }
    SUGGESTED[SUGGESTED.len() - 1].1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_suggested_angle_passes_through_the_papers_values() {
        for (count, degrees) in [
            (10.0, 45.0),
            (25e3, 25.0),
            (40e3, 25.0),
            (50e3, 22.0),
            (80e3, 18.0),
            (120e3, 15.0),
            (1e6, 15.0),
        ] {
            assert_eq!(suggested_angle_deg(count), degrees, "{count}");
        }
        assert!((suggested_angle_deg(100e3) - 16.5).abs() < 1e-9);
        assert!((30.0..40.0).contains(&suggested_angle_deg(7.5e3)));
    }
}
