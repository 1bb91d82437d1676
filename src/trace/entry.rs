//! Where the kernels are compiled: each query once for each set of instructions, and the choice of the
//! set for a tree.

use super::binary::improved;
use super::collapse::collapse;
use super::kernel::Kernel;
use super::lanes::{Avx2, Avx512, Floats, MOST_LANES};
use super::query::{Bundle, RayTree, Scratch, Waiting};
use super::single::Beam;
use super::soup::Soup;
use super::tracer::{THOROUGH, binary_tree};
use super::wide::WideTree;
use super::{Hit, Ray, bundle, single};
use crate::instructions::Instructions;

/// The wide tree of a kernel, where this processor can run it.
pub fn tree(soup: &Soup, kernel: Kernel) -> Option<Box<dyn RayTree>> {
    match kernel {
        Kernel::Wide(Instructions::Avx512) => build::<Avx512, false>(soup),
        Kernel::Wide(Instructions::Avx2) => build::<Avx2, false>(soup),
        Kernel::Watertight(Instructions::Avx512) => build::<Avx512, true>(soup),
        Kernel::Watertight(Instructions::Avx2) => build::<Avx2, true>(soup),
        Kernel::Portable => None,
    }
}

fn build<F: Floats + 'static, const TIGHT: bool>(soup: &Soup) -> Option<Box<dyn RayTree>>
where
    WideTree<F, TIGHT>: RayTree,
{
    let present = F::detect()?;
    let binary = improved(&binary_tree(&soup.corners, THOROUGH));
    let tree: WideTree<F, TIGHT> = collapse(present, &binary, soup);
    Some(Box::new(tree))
}

/// The entry points: everything below them is inlined and so compiled for these instructions.
macro_rules! compile_for {
    ($floats:ty, $features:literal) => {
        impl<const TIGHT: bool> RayTree for WideTree<$floats, TIGHT> {
            fn bytes(&self) -> usize {
                size_of_val(self.lines.as_slice())
            }

            fn scratch(&self) -> Scratch {
                Scratch {
                    // A push writes all lanes, whatever it needs.
                    children: vec![0; self.stack_entries + MOST_LANES],
                    sorted: vec![0; self.stack_entries],
                    tiles: vec![Waiting::default(); self.stack_entries],
                }
            }

            fn closest(&self, ray: &Ray, scratch: &mut Scratch) -> Option<Hit> {
                #[target_feature(enable = $features)]
                fn cast<const TIGHT: bool>(
                    tree: &WideTree<$floats, TIGHT>,
                    ray: &Ray,
                    scratch: &mut Scratch,
                ) -> Option<Hit> {
                    let mut best = None;
                    let beam = Beam::new(tree.present, ray);
                    single::closest(tree, &beam, 0, &mut scratch.sorted, &mut best);
                    best
                }
                // SAFETY: `present` proves that the instructions exist.
                unsafe { cast(self, ray, scratch) }
            }

            fn occluded(&self, ray: &Ray, scratch: &mut Scratch) -> bool {
                #[target_feature(enable = $features)]
                fn cast<const TIGHT: bool>(
                    tree: &WideTree<$floats, TIGHT>,
                    ray: &Ray,
                    scratch: &mut Scratch,
                ) -> bool {
                    let beam = Beam::new(tree.present, ray);
                    single::occluded(tree, &beam, 0, &mut scratch.children)
                }
                // SAFETY: `present` proves that the instructions exist.
                unsafe { cast(self, ray, scratch) }
            }

            fn occluded_bundle(&self, rays: &Bundle, scratch: &mut Scratch, occluded: &mut [u64]) {
                #[target_feature(enable = $features)]
                fn cast<const TIGHT: bool>(
                    tree: &WideTree<$floats, TIGHT>,
                    rays: &Bundle,
                    scratch: &mut Scratch,
                    occluded: &mut [u64],
                ) {
                    bundle::occluded(tree, rays, scratch, occluded);
                }
                // SAFETY: `present` proves that the instructions exist.
                unsafe { cast(self, rays, scratch, occluded) }
            }

            fn closest_bundle(
                &self,
                rays: &Bundle,
                scratch: &mut Scratch,
                hits: &mut [Option<Hit>],
            ) {
                #[target_feature(enable = $features)]
                fn cast<const TIGHT: bool>(
                    tree: &WideTree<$floats, TIGHT>,
                    rays: &Bundle,
                    scratch: &mut Scratch,
                    hits: &mut [Option<Hit>],
                ) {
                    bundle::closest(tree, rays, scratch, hits);
                }
                // SAFETY: `present` proves that the instructions exist.
                unsafe { cast(self, rays, scratch, hits) }
            }
        }
    };
}

compile_for!(Avx512, "avx512f,avx512dq,avx2,fma,bmi1,bmi2,lzcnt,popcnt");
compile_for!(Avx2, "avx2,fma,bmi1,bmi2,lzcnt,popcnt");
