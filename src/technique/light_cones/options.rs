//! Parameters of the contender.

use crate::cache::cones::Rules;
use crate::entry::{parameters, words};
use crate::technique::direct_lighting::selection::Selection;

words! {
    /// Which texels a camera sample reads.
    pub enum Filter {
        /// The one that it lies in.
        Nearest = "nearest",
        /// The four around it, weighted bilinearly; all of them are updated.
        Bilinear = "bilinear",
        /// Four in each of the two sizes next to the wanted one, weighted by how near they are.
        Trilinear = "trilinear",
    }
}

words! {
    /// Which rays test the edges of cones whose light has been at rest.
    pub enum CalmTests {
        /// One in each cone.
        Each = "each",
        /// One in one of the cones, another one in each update.
        One = "one",
        /// None.
        Off = "off",
    }
}

words! {
    /// When new texels begin with the cones of the next coarser or finer one.
    pub enum Reuse {
        /// They do not.
        Never = "never",
        /// While nothing has changed for as long as `motion` says: those of the other size are what they should be.
        AtRest = "at-rest",
        /// Also while lights or shapes change.
        Always = "always",
    }
}

words! {
    /// What brings all samples back to entries at rest.
    pub enum Motion {
        /// Turns of their cones.
        Cones = "cones",
        /// Those, and for `first_updates` frames any change of lights and shapes of the scene.
        Scene = "scene",
    }
}

words! {
    /// What becomes of directions of a cone that lie below the surface.
    pub enum Horizon {
        /// They reflect nothing.
        Lost = "lost",
        /// Their light comes from the others: no light was sampled below the surface.
        Renormalised = "renormalised",
    }
}

words! {
    /// What cones are told in relation to.
    pub enum Orientation {
        /// The triangle of the texel: they turn with a shape that turns.
        Surface = "surface",
        /// The world: they stay towards lights that stay.
        World = "world",
    }
}

words! {
    /// Where texels are whose centre another surface cuts off from the camera sample that asks for them first.
    pub enum CutOff {
        /// At the camera sample.
        Moved = "moved",
        /// At their centre.
        Kept = "kept",
    }
}

words! {
    /// How lights that were hidden from a block of texels of late are chosen.
    pub enum HiddenLights {
        /// In proportion to the share of their samples that arrived.
        Remembered = "remembered",
        /// As those that were seen.
        AsSeen = "as-seen",
    }
}

parameters! {
    #[derive(Clone, Copy, Debug)]
    pub struct Parameters {
        /// How cones take up samples and lose light that is gone.
        pub rules: Rules = Rules::default();
        /// Which texels a camera sample reads.
        pub filter: Filter = Filter::Bilinear;
        /// Where texels are that another surface cuts off.
        pub cut_off: CutOff = CutOff::Moved;
        /// How the lights of an update are chosen.
        pub selection: Selection = Selection::Product;
        /// Candidates of each sample, for selection = "product".
        pub candidates: u32 = 16, Within(1.0, 65536.0);
        /// How lights that were hidden from a block of late are chosen, for selection = "product".
        pub hidden: HiddenLights = HiddenLights::Remembered;
        /// Size of texels above that of pixels, in doublings.
        pub bias: f32 = 1.0, Within(-8.0, 8.0), "levels";
        /// Texels of the finest size along the diagonal of the scene; there are sixteen sizes.
        pub finest: f32 = 65536.0, Within(1.0, 1e6);
        /// Updates at all samples before an entry is at rest.
        pub first_updates: u32 = 8, Within(0.0, 65536.0);
        /// What brings all samples back to entries at rest.
        pub motion: Motion = Motion::Scene;
        /// Samples of an update of entries at rest.
        pub calm_samples: u32 = 1, Within(1.0, 65536.0);
        /// Tests of cones of entries at rest.
        pub calm_tests: CalmTests = CalmTests::One;
        /// Part of a cone's mean radiance that the environment must have at its edge to count as light there.
        pub bright_sky: f32 = 0.01, Within(0.0, 1.0);
        /// Directions of each cone that are put into the material.
        pub shading_samples: u32 = 16, Within(1.0, 4096.0);
        /// What becomes of those below the surface.
        pub horizon: Horizon = Horizon::Lost;
        /// What cones are told in relation to.
        pub orientation: Orientation = Orientation::Surface;
        /// When new texels begin with the cones of the next coarser or finer one.
        pub reuse: Reuse = Reuse::AtRest;
        /// Part of their count that those keep.
        pub reused_count: f32 = 0.5, Within(0.0, 1.0);
        /// Whether entries are kept in the 286 bits of the paper and 24 that tell changes; light above 131,064 is cut off.
        pub compressed: bool = false;
        /// Blocks of 8 × 8 texels at most; what finds no room is lit by as many lights as a texel would sample.
        pub most_blocks: usize = 1 << 18, Within(0.0, 16_777_216.0);
        /// Frames without a request after which a block is given up.
        pub keep_frames: u32 = 60, Within(0.0, 1_000_000.0), "frames";
    }
}
