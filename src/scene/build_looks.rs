//! What of a scene is neither triangles nor cameras: materials with their textures, and light.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::texture_file::estimated_bytes;
use super::{
    LightKind, Material, Needs, Scene, SceneDescription, SceneError, Shape, Texture,
    TextureDescription,
};
use crate::environment::{Environment, EnvironmentDescription, EnvironmentError};
use crate::image::file_of;

impl Scene {
    pub(super) fn add_materials(
        &mut self,
        description: &SceneDescription,
        needs: Needs,
    ) -> Result<(), SceneError> {
        self.report.cost.materials = size_of_val(&description.materials[..]);
        let used = used_textures(description, &self.shapes);
        self.report.cost.textures = used
            .iter()
            .filter_map(|&i| estimated_bytes(&description.textures[i]))
            .sum();
        if !needs.materials {
            return Ok(());
        }
        self.materials = description.materials.clone();
        self.textures = vec![Texture::default(); description.textures.len()];
        if !needs.textures {
            return Ok(());
        }
        let is_present = |t: &TextureDescription| t.path().is_none_or(|p| file_of(p).exists());
        let loaded: Vec<(usize, Option<Result<Texture, SceneError>>)> = used
            .into_par_iter()
            .map(|i| {
                let texture = &description.textures[i];
                (i, is_present(texture).then(|| Texture::load(texture)))
            })
            .collect();
        for (i, result) in loaded {
            match result {
                Some(texture) => self.textures[i] = texture?,
                None => {
                    let path = description.textures[i].path().unwrap_or("".as_ref());
                    let message = format!("texture {} is absent: 0.5 instead", path.display());
                    self.report.absent.push(message);
                }
            }
        }
        let odd = out_of_range(description, &self.textures);
        self.report.notes.extend(odd);
        let notes = self.textures.iter().flat_map(Texture::notes);
        self.report.notes.extend(notes.cloned());
        self.report.notes.extend(self.alphas_left_out(description));
        self.report.texture_bytes = self.textures.iter().map(Texture::bytes).sum();
        self.report.cost.textures = self.report.texture_bytes;
        Ok(())
    }

    /// Pictures with an alpha that no texture reads. (In glTF materials decide, and their reader tells.)
    fn alphas_left_out(&self, description: &SceneDescription) -> BTreeSet<String> {
        let all = description.textures.iter().zip(&self.textures);
        let read: BTreeSet<_> = description
            .textures
            .iter()
            .filter(|texture| texture.alpha.is_some())
            .filter_map(TextureDescription::path)
            .collect();
        all.filter(|(_, texture)| texture.translucent() > 0)
            .filter_map(|(declared, texture)| {
                let path = declared.path().filter(|path| !read.contains(path))?;
                let pixels = texture.translucent();
                Some(format!(
                    "{}: {pixels} pixels are not opaque; their alpha is left out",
                    path.display()
                ))
            })
            .collect()
    }

    pub(super) fn add_lights(
        &mut self,
        description: &SceneDescription,
        needs: Needs,
    ) -> Result<(), SceneError> {
        if needs.emitters {
            let lights = description.lights.iter().map(|light| &light.kind);
            let (dark, lit): (Vec<&LightKind>, Vec<&LightKind>) =
                lights.partition(|light| *light.strength() == [0.0; 3]);
            let shines = !lit.is_empty();
            self.set_lights_without_extent(lit);
            if shines && description.materials.iter().any(Material::is_frosted) {
                let note = "point, spot and directional lights do not show in frosted glass";
                self.report.notes.push(note.into());
            }
            let dark = dark.len();
            if dark > 0 {
                let note = format!("lights of no strength are left out: {dark}");
                self.report.notes.push(note);
            }
        } else if needs.environment && !description.lights.is_empty() {
            let note =
                "point, spot and directional lights are left out: light is the environment's";
            self.report.notes.push(note.into());
        }
        let Some(environment) = &description.environment else {
            return Ok(());
        };
        if let EnvironmentDescription::Map { path, .. } = environment {
            let map = TextureDescription::file(path.clone());
            self.report.cost.environment = estimated_bytes(&map).unwrap_or(0);
            if !file_of(path).exists() {
                if needs.environment {
                    let shown = path.display();
                    let message = format!("environment map {shown} is absent: no light from it");
                    self.report.absent.push(message);
                }
                return Ok(());
            }
        }
        if needs.environment {
            self.load_environment(environment)?;
        }
        Ok(())
    }

    fn load_environment(&mut self, declared: &EnvironmentDescription) -> Result<(), SceneError> {
        let environment = Environment::from_description(declared).map_err(|error| match error {
            EnvironmentError::Read { path, message } => SceneError::File {
                file: path,
                message,
            },
            other => SceneError::Scene {
                scene: self.name.clone(),
                message: other.to_string(),
            },
        })?;
        self.report.notes.extend(environment.notes());
        self.report.environment_bytes = environment.bytes();
        self.report.cost.environment = environment.bytes();
        self.environment = Some(environment);
        Ok(())
    }
}

/// Pictures that say what a surface reflects and hold what none does.
fn out_of_range(description: &SceneDescription, textures: &[Texture]) -> Vec<String> {
    let materials = description.materials.iter();
    let colours: BTreeSet<usize> = materials.flat_map(Material::colour_textures).collect();
    let note = |i: usize| {
        let count = textures.get(i)?.out_of_range();
        let path = description.textures[i].path()?.display();
        (count > 0).then(|| format!("{path}: {count} texels outside of [0, 1] are kept"))
    };
    colours.into_iter().filter_map(note).collect()
}

/// Textures of the materials of the shapes that have triangles.
fn used_textures(description: &SceneDescription, shapes: &[Shape]) -> Vec<usize> {
    let materials: BTreeSet<u32> = shapes
        .iter()
        .filter(|s| s.triangle_count > 0)
        .map(|s| s.material)
        .collect();
    let used = materials.into_iter().map(|i| i as usize);
    let textures: BTreeSet<usize> = used.flat_map(|i| description.textures_of(i)).collect();
    textures
        .into_iter()
        .filter(|&i| i < description.textures.len())
        .collect()
}
