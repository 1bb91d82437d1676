//! Texels whose point lies within or behind another surface than those of the camera samples that ask for them.

use glam::Vec3;
use rayon::prelude::*;

use super::options::Parameters;
use super::sight::{Look, Sight};
use super::texels::{Surfaces, hit_of, normal_of};
use crate::cache::surface::{BlockKey, SurfacePoint, Texel};
use crate::memory::concatenated;
use crate::technique::Shot;
use crate::trace::{Ray, RayCounter, offset_origin};

/// A surface point that a camera sees, for a texel that it asks for.
#[derive(Clone, Copy)]
struct Witness {
    texel: Texel,
    /// Squared distance from the texel's centre in the chart, scene units².
    distance2: f32,
    point: SurfacePoint,
    /// Whether the way from there to the texel is blocked.
    cut_off: bool,
}

impl Witness {
    /// Of a texel's witnesses the least is taken, whoever saw it.
    fn order(&self) -> (BlockKey, [u32; 5]) {
        let SurfacePoint { triangle, u, v } = self.point;
        let [distance2, u, v] = [self.distance2, u, v].map(f32::to_bits);
        let Texel { block, index } = self.texel;
        (block, [index, distance2, triangle, u, v])
    }
}

/// Moves the points of texels that begin to where a camera sees their surface, if the way from there to them is blocked.
/// Returns how many.
pub(super) fn uncover(
    surfaces: &mut Surfaces,
    seen: &[(&Shot, &Sight)],
    parameters: &Parameters,
    counter: &RayCounter,
) -> u64 {
    let Some((first, _)) = seen.first() else {
        return 0;
    };
    if !surfaces.blocks.any_begins() {
        return 0;
    }
    let known = &*surfaces;
    let witnesses = |(shot, sight): &(&Shot, &Sight)| witnesses(known, shot, sight, parameters);
    let mut all = concatenated(seen.iter().flat_map(witnesses).collect());
    // Sorted parts one after another are runs, which a stable sort merges, with all threads.
    all.par_sort_by_key(Witness::order);
    let of_each = all.par_chunk_by(|a, b| a.texel == b.texel);
    let mut witnesses: Vec<Witness> = of_each.map(|witnesses| witnesses[0]).collect();
    drop(all);
    witnesses.par_iter_mut().for_each_init(
        || first.tracer.caster(counter),
        |caster, witness| {
            let way = way_to_texel(known, first, witness);
            witness.cut_off = way.is_some_and(|way| first.paths.occluded(caster, &way));
        },
    );
    surfaces.blocks.begin_texels(&witnesses, |witness| {
        (witness.texel, witness.cut_off.then_some(witness.point))
    });
    let moved = witnesses.iter().filter(|witness| witness.cut_off);
    moved.count() as u64
}

/// What a viewer sees of texels that begin, in parts; in each of them one witness for each texel.
fn witnesses(
    surfaces: &Surfaces,
    shot: &Shot,
    sight: &Sight,
    parameters: &Parameters,
) -> Vec<Vec<Witness>> {
    let row = (shot.width * shot.spp as usize).max(1);
    let rows = sight.looks.par_chunks(row).map(|looks| {
        let mut found = Vec::new();
        for Look { hit, address, .. } in looks.iter().flatten() {
            let Some(address) = address else { continue };
            address.for_each_texel(&surfaces.grid, parameters.filter, |texel, _| {
                if surfaces.blocks.begins(texel) {
                    found.push(Witness {
                        texel,
                        distance2: surfaces
                            .grid
                            .centre(texel)
                            .distance_squared(address.place()),
                        point: SurfacePoint {
                            triangle: hit.triangle,
                            u: hit.u,
                            v: hit.v,
                        },
                        cut_off: false,
                    });
                }
            });
        }
        found.sort_unstable_by_key(Witness::order);
        found.dedup_by_key(|witness| witness.texel);
        found
    });
    rows.collect()
}

/// From a witness to the point of its texel, both just above their surfaces; `None` where that is nowhere or the same.
fn way_to_texel(surfaces: &Surfaces, shot: &Shot, witness: &Witness) -> Option<Ray> {
    let (point, _) = surfaces.blocks.texel(witness.texel)?;
    if !point.is_somewhere() {
        return None;
    }
    let back = witness.texel.block.surface().back;
    let lifted = |point: SurfacePoint| {
        let at = shot.paths.surfaces().interact(&hit_of(point), Vec3::NEG_Z);
        let normal = normal_of(shot.scene, point.triangle, back);
        offset_origin(at.position, normal, shot.scene.diagonal)
    };
    let (from, to) = (lifted(witness.point), lifted(point));
    let way = to - from;
    Some(Ray {
        t_max: way.length(),
        ..Ray::new(from, way.try_normalize()?)
    })
}
