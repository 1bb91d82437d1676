//! What each part of a map's light adds: the classes of its texels, then the image of each method.

use super::canvas::{fitted_size, scaled, shown};
use super::figure::{Drawing, Head, Shown};
use super::font::Fonts;
use super::light_map::tinted;
use super::number;
use super::overlay::arrange;
use super::pictures::Pictures;
use crate::image::{Image, Size};

/// Longest side of an image.
const SIDE: usize = 800;

/// The classified map, if a method tells emissive texels apart, and the images, in one line or two.
pub fn draw(fonts: &Fonts, methods: &[Shown], head: Head) -> Result<Drawing, String> {
    let there: Vec<(&str, &Pictures)> = methods
        .iter()
        .filter_map(|(label, pictures)| Some((*label, (*pictures)?)))
        .collect();
    let Some((_, first)) = there.first() else {
        return Err("no images of these methods".into());
    };
    let size = fitted_size(first.beauty.size(), Size::new(SIDE, SIDE));
    let classified = there
        .iter()
        .filter_map(|(_, pictures)| pictures.lights.as_ref())
        .find(|own| !own.emissive.is_empty());
    let map = classified.map(|own| ("emissive texels red".to_owned(), within(&tinted(own), size)));
    let images = there.iter().map(|(label, pictures)| {
        let image = shown(&pictures.beauty, pictures.exposure, size);
        ((*label).to_owned(), image)
    });
    let panels: Vec<(String, Image)> = map.into_iter().chain(images).collect();
    Ok(Drawing {
        sheet: arrange(fonts, &panels, head),
        caption: format!(
            "Images by each part of the light, {}, seed {}; all at one exposure.",
            number::budget(&first.row.budget),
            first.row.seed
        ),
    })
}

/// The map as large as it fits.
fn within(map: &Image, size: Size) -> Image {
    scaled(map, fitted_size(map.size(), size))
}
