//! The files that a scene names, and what becomes of a scene without them.

use super::{BuildReport, Needs, SceneDescription, SceneError};
use crate::environment::EnvironmentDescription;
use crate::image::file_of;

/// A file that is not there, in words, and whether light comes from it.
struct Absent {
    what: String,
    shines: bool,
}

impl SceneDescription {
    /// Fails when a file that the technique needs is absent. Where the scene is `incomplete` by
    /// declaration, meshes, textures and material libraries may be; what shines may not, because nothing stands for it.
    ///
    /// # Errors
    /// [`SceneError::Scene`] with the files and what to do.
    pub fn require_files(&self, needs: Needs, incomplete: bool) -> Result<(), SceneError> {
        let absent = self.absent_files(needs);
        let counts = |a: &&Absent| a.shines || !incomplete;
        let refused: Vec<&Absent> = absent.iter().filter(counts).collect();
        let Some(first) = refused.first() else {
            return Ok(());
        };
        let others = match refused.len() {
            1 => String::new(),
            n => format!(" (and {} more)", n - 1),
        };
        let advice = match first.shines {
            true => "light comes from it: put it there, or replace it",
            false => "put it there, or say `incomplete = true` to go on without",
        };
        Err(SceneError::Scene {
            scene: self.name.clone(),
            message: format!("{} is absent{others}; {advice}", first.what),
        })
    }

    /// Indices of the textures of a material and of all that it refers to.
    pub(super) fn textures_of(&self, material: usize) -> Vec<usize> {
        let mut textures = Vec::new();
        let mut pending = vec![material];
        while let Some(material) = pending.pop().and_then(|i| self.materials.get(i)) {
            textures.extend(material.textures());
            pending.extend(material.others());
        }
        textures
    }

    fn absent_files(&self, needs: Needs) -> Vec<Absent> {
        let mut absent = Vec::new();
        if let Some(EnvironmentDescription::Map { path, .. }) = &self.environment
            && needs.environment
            && !file_of(path).exists()
        {
            absent.push(Absent {
                what: format!("environment map {}", path.display()),
                shines: true,
            });
        }
        for shape in &self.shapes {
            if let Some(path) = shape.source.path().filter(|path| !path.exists()) {
                absent.push(Absent {
                    what: format!("{} of shape `{}`", path.display(), shape.name),
                    shines: needs.emitters && shape.emission.is_some(),
                });
            }
        }
        let shining = self.shapes.iter().filter_map(|s| s.emission_texture);
        let shining = shining.filter_map(|i| self.textures.get(i)?.path());
        absent.extend(
            shining
                .filter(|path| !file_of(path).exists())
                .map(|path| Absent {
                    what: format!("texture {} of a light", path.display()),
                    shines: needs.emitters,
                }),
        );
        if needs.textures {
            let used = self.shapes.iter().map(|shape| shape.material);
            let mut used: Vec<usize> = used.flat_map(|i| self.textures_of(i)).collect();
            used.sort_unstable();
            used.dedup();
            let paths = used
                .into_iter()
                .filter_map(|i| self.textures.get(i)?.path());
            absent.extend(
                paths
                    .filter(|path| !file_of(path).exists())
                    .map(|path| Absent {
                        what: format!("texture {}", path.display()),
                        shines: false,
                    }),
            );
        }
        if needs.materials {
            let libraries = self.absent_libraries.iter();
            absent.extend(libraries.map(|path| Absent {
                what: format!("material library {}", path.display()),
                shines: false,
            }));
        }
        // What shines first: no declaration helps there.
        absent.sort_by_key(|a| !a.shines);
        absent
    }
}

impl BuildReport {
    /// All that was left out, repaired, approximated or replaced, a sentence each.
    pub fn sentences(&self) -> Vec<String> {
        let counted = [
            (
                self.dropped_degenerate,
                "triangles without an area are left out",
            ),
            (
                self.dropped_non_finite,
                "triangles that are not finite are left out",
            ),
            (
                self.repaired_normals,
                "vertex normals without a direction are replaced",
            ),
            (
                self.reoriented,
                "triangles are turned to the side of their normals",
            ),
        ];
        let counted = counted.iter().filter(|(count, _)| *count > 0);
        let counted = counted.map(|(count, what)| format!("{count} {what}"));
        let told = self.absent.iter().chain(&self.notes).cloned();
        told.chain(counted).collect()
    }
}
