//! Which layer of an EXR file is the picture.

use std::path::Path;

use super::{ImageError, Layer, Samples};

/// Last parts of the names of channels that OpenEXR reserves for depth, alpha and identities.
const NO_PICTURES: [&str; 7] = ["z", "zback", "a", "ar", "ag", "ab", "id"];

/// Last parts of the names of layers that hold the finished picture.
const FINISHED: [&str; 6] = ["combined", "composite", "beauty", "image", "rgba", "rgb"];

/// A layer that is the picture.
pub(super) struct PictureLayer {
    /// Among those of the file.
    pub index: usize,
    /// A note on other layers that could be meant.
    pub passed_over: Option<String>,
}

impl PictureLayer {
    /// A layer that alone can be meant.
    pub fn of(index: usize) -> Self {
        let passed_over = None;
        Self { index, passed_over }
    }
}

/// The layer that is the picture, if there is one.
///
/// # Errors
/// Several that could be meant equally well.
pub(super) fn picture_of(
    path: &Path,
    layers: &[Layer],
) -> Result<Option<PictureLayer>, ImageError> {
    let is_color = |layer: &Layer| matches!(layer.samples, Samples::Color(_));
    let colours: Vec<usize> = (0..layers.len())
        .filter(|&i| is_color(&layers[i]))
        .collect();
    if let Some(unnamed) = colours.iter().find(|&&i| layers[i].name.is_empty()) {
        return Ok(Some(PictureLayer::of(*unnamed)));
    }
    let last_part = |i: usize| {
        layers[i]
            .name
            .rsplit('.')
            .next()
            .unwrap_or("")
            .to_lowercase()
    };
    let finished: Vec<usize> = FINISHED
        .iter()
        .map(|word| {
            colours
                .iter()
                .copied()
                .filter(|&i| last_part(i) == *word)
                .collect()
        })
        .find(|found: &Vec<usize>| !found.is_empty())
        .unwrap_or_else(|| colours.clone());
    match finished[..] {
        [] => {}
        [only] => {
            let others: Vec<&str> = colours
                .iter()
                .filter(|&&i| i != only && FINISHED.contains(&last_part(i).as_str()))
                .map(|&i| layers[i].name.as_str())
                .collect();
            let (others, name) = (others.join("`, `"), &layers[only].name);
            let note = format!(
                "layer `{name}` is taken, while `{others}` could be the picture as well: `FILE#LAYER` names another"
            );
            return Ok(Some(PictureLayer {
                index: only,
                passed_over: (!others.is_empty()).then_some(note),
            }));
        }
        _ => {
            let names: Vec<&str> = finished.iter().map(|&i| layers[i].name.as_str()).collect();
            return Err(ImageError::SeveralLayers {
                path: path.to_owned(),
                found: names.join(", "),
                first: names[0].to_owned(),
            });
        }
    }
    let unnamed = layers.iter().position(|layer| layer.name.is_empty());
    let only = layers.len() == 1 && !NO_PICTURES.contains(&last_part(0).as_str());
    Ok(unnamed.or(only.then_some(0)).map(PictureLayer::of))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Image;

    #[test]
    fn other_layers_that_could_be_the_picture_are_told() {
        let chosen = |names: &[&str]| {
            let layers: Vec<Layer> = names
                .iter()
                .map(|name| Layer::color(*name, Image::new(1, 1)))
                .collect();
            let found = picture_of(Path::new("a.exr"), &layers).expect("one");
            found.map(|found| (found.index, found.passed_over))
        };
        assert_eq!(chosen(&["", "beauty", "Combined"]), Some((0, None)));
        assert_eq!(chosen(&["diffuse", "beauty"]), Some((1, None)));
        let (index, note) = chosen(&["beauty", "View.Combined", "rgb"]).expect("a picture");
        let note = note.expect("a note");
        assert_eq!(index, 1);
        assert!(
            note.starts_with("layer `View.Combined` is taken, while `beauty`, `rgb` could"),
            "{note}"
        );
    }
}
