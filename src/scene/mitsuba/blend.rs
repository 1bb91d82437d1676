//! Materials that are mixed of others: `blendbsdf` and, of version 0.x, `mixturebsdf`.

use super::Importer;
use super::bsdf::{MAX_NESTING, black, diffuse_of, one_sided};
use super::element::Element;
use super::spectrum::list;
use crate::scene::{Blend, Bsdf, ColourSource, Material, SceneError};

/// Sums of weights up to which nothing counts as lost: files have few digits.
const WHOLE: f64 = 1.0 - 1e-6;

impl<'a> Importer<'a> {
    /// Two materials of which rays meet one by chance.
    pub(super) fn blend(
        &mut self,
        element: &'a Element,
        depth: usize,
    ) -> Result<Material, SceneError> {
        let share = self.colour_source(element, &["weight"], 0.5)?;
        let nested = self.nested(element, "bsdf")?;
        let [first, second] = nested[..] else {
            let found = nested.len();
            let message = format!("`blendbsdf` needs two materials inside, found {found}");
            return Err(element.error(message));
        };
        let materials = [self.part(first, depth)?, self.part(second, depth)?];
        Ok(self.blend_of(materials, share))
    }

    /// A material in whose place a ray meets one of two others, the second by a chance.
    fn blend_of(&self, materials: [usize; 2], second: ColourSource) -> Material {
        // Not a mirror: what is behind it is not all that is seen.
        let shown = materials
            .into_iter()
            .find(|&i| !self.scene.materials[i].is_specular());
        Material {
            back: None,
            blend: Some(Blend { materials, second }),
            ..self.scene.materials[shown.unwrap_or(materials[0])].clone()
        }
    }

    /// A blend of two diffuse materials of constant colours, which is one with the mean colour; `None` for others.
    pub(super) fn diffuse_blend(
        &mut self,
        element: &'a Element,
        depth: usize,
    ) -> Result<Option<Material>, SceneError> {
        if !self.may_be_mixed(element, depth)? {
            return Ok(None);
        }
        let nested = self.nested(element, "bsdf")?;
        let [first, second] = nested[..] else {
            return Ok(None);
        };
        let weight = element.float("weight")?.unwrap_or(0.5).clamp(0.0, 1.0) as f32;
        let mut mixed = self.bsdf(first, depth + 1)?;
        let other = self.bsdf(second, depth + 1)?;
        let (Bsdf::Diffuse { reflectance }, Bsdf::Diffuse { reflectance: with }) =
            (&mut mixed.bsdf, other.bsdf)
        else {
            return Ok(None);
        };
        let (ColourSource::Constant(a), ColourSource::Constant(b)) = (*reflectance, with) else {
            return Ok(None);
        };
        let mean = std::array::from_fn(|c| a[c] + (b[c] - a[c]) * weight);
        *reflectance = ColourSource::Constant(mean);
        Ok(Some(mixed))
    }

    /// Whether a material is diffuse, or a blend of such by a number.
    fn may_be_mixed(&mut self, element: &'a Element, depth: usize) -> Result<bool, SceneError> {
        if depth > MAX_NESTING || element.kind() != "blendbsdf" {
            return Ok(element.kind() == "diffuse");
        }
        let is_number = element.child("weight").is_some_and(|w| w.tag == "float");
        let nested = self.nested(element, "bsdf")?;
        if !is_number || nested.len() != 2 {
            return Ok(false);
        }
        Ok(self.may_be_mixed(nested[0], depth + 1)? && self.may_be_mixed(nested[1], depth + 1)?)
    }

    /// Any number of materials with weights. What the weights lack to 1 is lost; where they are more, all are made smaller.
    pub(super) fn mixture(
        &mut self,
        element: &'a Element,
        depth: usize,
    ) -> Result<Material, SceneError> {
        let nested = self.nested(element, "bsdf")?;
        let weights = self.weights(element, nested.len())?;
        if nested.iter().all(|part| part.kind() == "diffuse")
            && let Some(mean) = self.diffuse_mean(&nested, &weights, depth)?
        {
            return Ok(one_sided(diffuse_of(ColourSource::Constant(mean))));
        }
        let mut parts = Vec::new();
        for (part, &weight) in nested.iter().zip(&weights) {
            if weight > 0.0 {
                parts.push((self.part(part, depth)?, weight));
            } else {
                part.mark_all();
            }
        }
        let lost = 1.0 - weights.iter().sum::<f64>();
        if lost > 1.0 - WHOLE {
            parts.push((self.part_of(one_sided(black()), "nothing"), lost));
        }
        // From the last one: each is met, or what follows it.
        let Some((mut rest, mut of)) = parts.pop() else {
            return Err(element.error("a mixture without materials"));
        };
        let mut mixed = self.scene.materials[rest].clone();
        while let Some((part, weight)) = parts.pop() {
            let share = ColourSource::Constant([(of / (of + weight)) as f32; 3]);
            mixed = self.blend_of([part, rest], share);
            if !parts.is_empty() {
                rest = self.part_of(mixed.clone(), "mixturebsdf");
                of += weight;
            }
        }
        Ok(mixed)
    }

    /// The weights of a mixture: one for each of `count` materials, not below 0, of a sum of at most 1.
    fn weights(&mut self, element: &'a Element, count: usize) -> Result<Vec<f64>, SceneError> {
        let mut weights = list(element, "weights")?;
        let found = weights.len();
        let place = element.child("weights").unwrap_or(element);
        if found != count || count == 0 {
            let message = format!("`mixturebsdf` has {count} materials and {found} weights");
            return Err(place.error(message));
        }
        if !weights.iter().all(|w| w.is_finite() && *w >= 0.0) {
            return Err(place.error("the weights of a mixture must not be below 0"));
        }
        let sum: f64 = weights.iter().sum();
        if sum <= 0.0 || !sum.is_finite() {
            return Err(place.error("the weights of a mixture must have a sum above 0"));
        }
        let conserving = element.boolean("ensure_energy_conservation", true)?;
        if sum > 2.0 - WHOLE {
            let only = match conserving {
                true => "",
                false => ", whatever `ensureEnergyConservation` says",
            };
            self.note(format!(
                "the weights of a mixture have a sum of {sum}: they are divided by it{only}"
            ));
            weights.iter_mut().for_each(|w| *w /= sum);
        }
        Ok(weights)
    }

    /// The weighted sum of diffuse materials of constant colours; `None` for others.
    fn diffuse_mean(
        &mut self,
        parts: &[&'a Element],
        weights: &[f64],
        depth: usize,
    ) -> Result<Option<[f32; 3]>, SceneError> {
        let mut sum = [0.0; 3];
        for (part, weight) in parts.iter().zip(weights) {
            let Bsdf::Diffuse {
                reflectance: ColourSource::Constant(colour),
            } = self.bsdf(part, depth + 1)?.bsdf
            else {
                return Ok(None);
            };
            sum = std::array::from_fn(|c| sum[c] + f64::from(colour[c]) * weight);
        }
        Ok(Some(sum.map(|value| value as f32)))
    }
}
