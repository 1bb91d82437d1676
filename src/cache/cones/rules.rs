//! How cones take up samples, as far as the paper leaves it open.

use crate::entry::{Kind, Setting, parameters, words};

words! {
    /// What is compared where an entry has all its cones and a sample is outside of them.
    pub enum Comparison {
        /// Gaps between the edges of cones.
        Gaps = "gaps",
        /// Angles between their axes.
        Axes = "axes",
        /// Widening that it takes, weighed by the light that is spread by it.
        Light = "light",
    }
}

words! {
    /// Which of several cones around a sample takes it.
    pub enum Inside {
        /// The one that it is deepest in, measured by half angles.
        Deepest = "deepest",
        /// The narrowest.
        Narrowest = "narrowest",
    }
}

words! {
    /// What the count of an entry counts.
    pub enum Weighting {
        /// Samples: an update with more of them weighs more.
        Samples = "samples",
        /// Updates, whatever their samples.
        Updates = "updates",
    }
}

words! {
    /// What becomes of the light of a cone that no sample of an update falls into.
    pub enum Unlit {
        /// It is averaged with nothing, as all samples that reach no light.
        Fades = "fades",
        /// It stays.
        Stays = "stays",
    }
}

words! {
    /// How far a cone shrinks that shows no light at `δ` from its edge.
    pub enum Shrinking {
        /// Half angle and axis by δ/2: the far edge stays where it is.
        FarEdge = "far-edge",
        /// Half angle by δ and axis by δ/2, to the letter of the paper.
        Literal = "literal",
    }
}

words! {
    /// What becomes of small cones that show no light.
    pub enum SmallCones {
        /// They stay, and what they hold fades.
        Fade = "fade",
        /// They are removed with what they hold, as the paper says.
        Removed = "removed",
        /// They are removed where no sample of the update fell into them either.
        RemovedUnlit = "removed-unlit",
    }
}

parameters! {
    /// How cones take up samples and lose light that is gone.
    #[derive(Clone, Copy, Debug, serde::Serialize)]
    pub struct Rules {
        /// Cones of an entry at most.
        pub cones: usize = 3, Within(1.0, 8.0);
        /// Half angle of a new cone, and the least of any.
        pub least_angle_deg: f32 = 1.43, Within(0.01, 90.0), "degrees";
        /// What is compared before a cone is widened or two are merged.
        pub comparison: Comparison = Comparison::Light;
        /// Which of several cones around a sample takes it.
        pub inside: Inside = Inside::Narrowest;
        /// What the count of an entry counts.
        pub weighting: Weighting = Weighting::Samples;
        /// Most that is counted: how far the mean reaches back.
        pub most_count: f32 = 255.0, Within(1.0, 255.0);
        /// What becomes of light that no sample of an update finds.
        pub unlit: Unlit = Unlit::Fades;
        /// Turn of a cone's axis in an update from which on it counts as a change of the light.
        pub turn_deg: f32 = 1.0, AtLeast(0.0), "degrees";
        /// Count from which on such a change lowers it; 256 never does.
        pub turn_count: f32 = 4.0, Within(0.0, 256.0);
        /// While the scene changes the count is multiplied by the part of an update's light that arrives within the cones of
        /// before, or as one of the two brightest samples from elsewhere, to this power: light from elsewhere has moved. 0
        /// never lowers it.
        pub news: f32 = 8.0, Within(0.0, 100.0);
        /// What the count is divided by where the scene changes and a cone is met by none of at least four samples and dark at
        /// its edge, if all samples of the update reached their light; to the power of the part that did.
        pub doubt: f32 = 8.0, Within(1.0, 255.0);
        /// What the count is divided by, at least, where what the last updates brought differs from the light of an entry.
        pub surprised: f32 = 3.0, Within(1.0, 255.0);
        /// Standard deviations by which what the last updates brought must differ from the light of an entry for it to have
        /// changed; 1000 never.
        pub surprise: f32 = 1.0, Within(0.0, 1000.0);
        /// How much of what the last updates brought is the newest one.
        pub recent: f32 = 0.25, Within(0.01, 1.0);
        /// Variance that is put down to chance: the light of an entry times that of its brightest sample, times this, as the
        /// number of samples is known from a few updates only.
        pub seldom: f32 = 2.0, AtLeast(0.0);
        /// ε: where the edge of a cone is tested for light, as a part of its half angle.
        pub edge: f32 = 0.1, Within(0.0, 1.0);
        /// How far a cone without light at its edge shrinks.
        pub shrinking: Shrinking = Shrinking::FarEdge;
        /// Half angle below which a cone is small.
        pub small_deg: f32 = 2.0, AtLeast(0.0), "degrees";
        /// What becomes of small cones without light.
        pub small_cones: SmallCones = SmallCones::Fade;
        /// Part of an entry's light below which a cone that no sample of the update fell into is given up.
        pub negligible: f32 = 0.001, Within(0.0, 1.0);
    }
}

impl Setting for Rules {
    const KIND: Kind = Kind::Table(Self::PARAMETERS);
}

impl Rules {
    /// What an update of so many samples adds to the count of an entry.
    pub(super) fn weight_of(&self, samples: u32) -> f32 {
        match self.weighting {
            Weighting::Samples => samples as f32,
            Weighting::Updates => 1.0,
        }
    }

    /// Half angle of a new cone, radians.
    pub(super) fn least_angle(&self) -> f32 {
        self.least_angle_deg.to_radians()
    }
}
