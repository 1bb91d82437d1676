//! All lights at one surface point: the sum that importance caching samples.

use glam::Vec3;

use super::connect::{REACH, Receiver};
use super::{LANES, VirtualLights};
use crate::trace::Caster;

/// Rays of a bundle.
const BUNDLE: usize = 64;

/// Buffers of one thread.
pub struct Gathering {
    waiting: usize,
    indices: [u32; BUNDLE],
    values: [Vec3; BUNDLE],
    ways: [Vec3; BUNDLE],
}

impl Default for Gathering {
    fn default() -> Self {
        Self {
            waiting: 0,
            indices: [0; BUNDLE],
            values: [Vec3::ZERO; BUNDLE],
            ways: [Vec3::ZERO; BUNDLE],
        }
    }
}

impl VirtualLights<'_> {
    /// Calls `visit(light, unoccluded, visible)` for each light whose unoccluded contribution is not
    /// black, in the order of the set. Lights that are black at the receiver cost no ray.
    pub fn each(
        &self,
        caster: &Caster,
        to: &Receiver,
        buffers: &mut Gathering,
        visit: &mut dyn FnMut(usize, Vec3, bool),
    ) {
        for block in 0..self.facing.len() {
            let mut faced = self.faced(to, block);
            while faced != 0 {
                let index = block * LANES + faced.trailing_zeros() as usize;
                faced &= faced - 1;
                self.wait(caster, to, index, buffers, visit);
            }
        }
        for index in self.on_surfaces..self.finite {
            self.wait(caster, to, index, buffers, visit);
        }
        self.flush(caster, to, buffers, visit);
        for index in self.finite..self.len() {
            self.wait(caster, to, index, buffers, visit);
        }
        self.flush(caster, to, buffers, visit);
    }

    /// Puts a light in line, unless it adds nothing, and casts the rays when the line is full.
    fn wait(
        &self,
        caster: &Caster,
        to: &Receiver,
        index: usize,
        buffers: &mut Gathering,
        visit: &mut dyn FnMut(usize, Vec3, bool),
    ) {
        let value = self.unoccluded(to, index);
        if value == Vec3::ZERO {
            return;
        }
        let light = &self.lights[index];
        let slot = buffers.waiting;
        buffers.indices[slot] = index as u32;
        buffers.values[slot] = value;
        buffers.ways[slot] = if index < self.finite {
            light.end - to.origin
        } else {
            light.normal
        };
        buffers.waiting += 1;
        if buffers.waiting == BUNDLE {
            self.flush(caster, to, buffers, visit);
        }
    }

    /// Casts the waiting rays. Those to lights with a position are made as long as their way is of the
    /// longest one, so that one limit ends each at its light.
    fn flush(
        &self,
        caster: &Caster,
        to: &Receiver,
        buffers: &mut Gathering,
        visit: &mut dyn FnMut(usize, Vec3, bool),
    ) {
        let count = std::mem::take(&mut buffers.waiting);
        if count == 0 {
            return;
        }
        let ways = &mut buffers.ways[..count];
        let mut limit = f32::INFINITY;
        if (buffers.indices[0] as usize) < self.finite {
            let lengths = ways.iter().map(|w| w.length());
            let longest = lengths.fold(f32::MIN_POSITIVE, f32::max);
            ways.iter_mut().for_each(|w| *w /= longest);
            limit = longest * REACH;
        }
        let mut blocked = [0u64];
        let paths = self.paths_of_scene;
        paths.occluded_bundle(caster, to.origin, ways, limit, &mut blocked);
        for k in 0..count {
            let visible = blocked[0] >> k & 1 == 0;
            visit(buffers.indices[k] as usize, buffers.values[k], visible);
        }
    }

    /// Radiance that all lights together send to the receiver's viewer, and the number of lights
    /// left out because their contribution is not finite.
    pub fn sum(&self, caster: &Caster, to: &Receiver, buffers: &mut Gathering) -> (Vec3, u64) {
        let mut sum = glam::DVec3::ZERO;
        let mut non_finite = 0;
        let mut add = |_, value: Vec3, visible: bool| {
            if !value.is_finite() {
                non_finite += 1;
            } else if visible {
                sum += value.as_dvec3();
            }
        };
        self.each(caster, to, buffers, &mut add);
        (sum.as_vec3(), non_finite)
    }
}
