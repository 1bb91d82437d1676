//! Cones of incoming light: what reaches a surface point, told by a few cones instead of all its directions (Stadlbauer
//! et al. 2024, "Surface Light Cones").
//!
//! A [`Cone`] has an axis, half an opening angle and the light that arrives within it. An [`Entry`] holds the cones of one
//! surface point and how many samples they are the mean of. An [`Update`] adds samples of lights to it (`insert`) and
//! closes cones where no light is left (`shrink`), and notices when the light has moved (`news`) or changed (`surprise`);
//! [`Rules`] has what the paper leaves open. [`Storage`] writes entries to memory, in full or in the 286 bits of the paper and
//! 24 more. Cones are in whatever frame their directions are given in.
//!
//! What a cone holds is light integrated over solid angle, `∫ L dω`, not a mean radiance: the shading sum of the paper has no
//! solid angle in it. Every sample of an update counts, also one that reaches no light.

mod cone;
mod entry;
mod insert;
mod news;
mod rules;
mod shrink;
mod storage;
mod surprise;

pub use cone::{Cone, angle_between};
pub use entry::{Entry, MOST_CONES};
pub use insert::Update;
pub use rules::{Comparison, Inside, Rules, Shrinking, SmallCones, Unlit, Weighting};
pub use shrink::EdgeTest;
pub use storage::Storage;
