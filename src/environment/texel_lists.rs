//! The texels of lights, to draw from in proportion to their luminance.

use rayon::prelude::*;

use super::texel_lights::NONE;
use super::texels::Texels;

/// Texels by light.
#[derive(Clone, Debug)]
pub(super) struct TexelLists {
    /// Where each light's texels begin; one more than there are lights.
    first: Vec<u32>,
    texels: Vec<u32>,
    /// Running sums over each light's texels of luminance · solid angle, the last of a light 1.
    running: Vec<f32>,
}

impl TexelLists {
    /// `of_texel` is the light of every texel, or [`NONE`].
    pub fn new(texels: &Texels, of_texel: Vec<u32>, lights: usize) -> Self {
        let mut first = vec![0u32; lights + 1];
        let members = || of_texel.iter().enumerate().filter(|(_, l)| **l != NONE);
        members().for_each(|(_, &light)| first[light as usize + 1] += 1);
        for light in 0..lights {
            first[light + 1] += first[light];
        }
        let mut next = first.clone();
        let mut list = vec![0u32; first[lights] as usize];
        for (texel, &light) in members() {
            let place = &mut next[light as usize];
            list[*place as usize] = texel as u32;
            *place += 1;
        }
        let mut running = vec![0.0f32; list.len()];
        let mut rest = &mut running[..];
        let mut runs = Vec::with_capacity(lights);
        for pair in first.windows(2) {
            let range = pair[0] as usize..pair[1] as usize;
            let (own, after) = rest.split_at_mut(range.len());
            runs.push((own, &list[range]));
            rest = after;
        }
        runs.into_par_iter().for_each(|(running, list)| {
            let total: f64 = list.iter().map(|&t| texels.energy(t as usize)).sum();
            let mut sum = 0.0;
            for (entry, &texel) in running.iter_mut().zip(list) {
                sum += texels.energy(texel as usize);
                *entry = (sum / total) as f32;
            }
            if let Some(last) = running.last_mut() {
                *last = 1.0;
            }
        });
        Self {
            first,
            texels: list,
            running,
        }
    }

    /// The texel of a light that `u` in [0, 1) falls into, and its probability; `None` for a light
    /// without texels.
    pub fn texel(&self, light: usize, u: f32) -> Option<(u32, f32)> {
        let range = self.first[light] as usize..self.first[light + 1] as usize;
        let running = &self.running[range.clone()];
        let index = running.partition_point(|&sum| sum <= u);
        let index = index.min(running.len().checked_sub(1)?);
        let before = if index == 0 { 0.0 } else { running[index - 1] };
        Some((self.texels[range.start + index], running[index] - before))
    }

    /// Number of texels of a light.
    #[cfg(test)]
    pub fn count(&self, light: usize) -> u32 {
        self.first[light + 1] - self.first[light]
    }
}
