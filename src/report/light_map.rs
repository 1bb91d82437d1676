//! Lights, and the classes of texels, drawn on the environment map they were made from.

use glam::Vec2;

use super::canvas::{disc, fitted_size, scaled};
use super::figure::{Drawing, Head, Shown};
use super::font::Fonts;
use super::number;
use super::overlay::{arrange, legend};
use super::pictures::{LightPictures, Pictures};
use crate::environment::LightKind;
use crate::image::{Image, Size};

const DIRECT: [f32; 3] = [0.95, 0.1, 0.08];
const INDIRECT: [f32; 3] = [0.12, 0.35, 1.0];
const RIM: [f32; 3] = [1.0; 3];

/// Marks lights at their map coordinates (u, v in [0, 1]) on a picture of the map: direct and global
/// ones red, indirect ones blue.
pub fn draw_lights(shown: &mut Image, lights: impl Iterator<Item = ([f32; 2], LightKind)>) {
    let size = [shown.width as f32, shown.height as f32];
    let radius = (size[0] / 150.0).max(2.5);
    for ([u, v], kind) in lights {
        let color = match kind {
            LightKind::Indirect => INDIRECT,
            LightKind::Direct | LightKind::Global => DIRECT,
        };
        let center = Vec2::new(u * size[0], v * size[1]);
        disc(shown, center, radius * 1.35, RIM);
        disc(shown, center, radius, color);
    }
}

fn those_with<'a>(
    methods: &[Shown<'a, 'a>],
) -> Vec<(&'a str, &'a Pictures<'a>, &'a LightPictures)> {
    methods
        .iter()
        .filter_map(|(label, p)| p.and_then(|p| Some((*label, p, p.lights.as_ref()?))))
        .collect()
}

/// The lights of each method on the map.
pub fn lights(fonts: &Fonts, methods: &[Shown], head: Head) -> Result<Drawing, String> {
    let there = those_with(methods);
    let Some((_, first, _)) = there.first() else {
        return Err("these methods kept no lights".into());
    };
    let panels: Vec<(String, Image)> = there
        .iter()
        .map(|(label, _, own)| {
            let panel = marked(&enlarged(&own.map), own);
            let count = |kind: LightKind| own.lights.iter().filter(|l| l.1 == kind).count() as u64;
            let text = match count(LightKind::Global) {
                0 => format!(
                    "{label}: {} direct + {} indirect",
                    number::count(count(LightKind::Direct)),
                    number::count(count(LightKind::Indirect))
                ),
                all => format!("{label}: {} lights", number::count(all)),
            };
            (text, panel)
        })
        .collect();
    let mut canvas = arrange(fonts, &panels, head);
    legend(
        &mut canvas,
        fonts,
        [
            ("direct or global light", DIRECT),
            ("indirect light", INDIRECT),
        ],
    );
    Ok(Drawing {
        sheet: canvas,
        caption: format!(
            "Lights on the tone-mapped map, {}, seed {}: direct and global ones red, indirect ones blue.",
            number::budget(&first.row.budget),
            first.row.seed
        ),
    })
}

/// The emissive texels of each method that tells them apart.
pub fn classes(fonts: &Fonts, methods: &[Shown], head: Head) -> Result<Drawing, String> {
    let panels: Vec<(String, Image)> = those_with(methods)
        .into_iter()
        .filter(|(_, _, own)| own.lights.iter().any(|l| l.1 != LightKind::Global))
        .map(|(label, _, own)| (label.to_owned(), enlarged(&tinted(own))))
        .collect();
    if panels.is_empty() {
        return Err("these methods do not tell emissive texels apart".into());
    }
    let mut canvas = arrange(fonts, &panels, head);
    legend(
        &mut canvas,
        fonts,
        [("emissive", DIRECT), ("not emissive", INDIRECT)],
    );
    Ok(Drawing {
        sheet: canvas,
        caption: "Texels on which direct lights stand red, all others blue.".into(),
    })
}

/// The lights on a picture of their map.
pub fn marked(map: &Image, own: &LightPictures) -> Image {
    let mut shown = map.clone();
    draw_lights(&mut shown, own.lights.iter().copied());
    shown
}

fn enlarged(map: &Image) -> Image {
    scaled(map, fitted_size(map.size(), Size::new(1024, 1024)))
}

/// The map with emissive texels red and all others blue.
pub fn tinted(own: &LightPictures) -> Image {
    let mut shown = own.map.clone();
    for (index, pixel) in shown.pixels.iter_mut().enumerate() {
        let emissive = own.emissive.contains(&(index as u32));
        let (color, share) = if emissive {
            (DIRECT, 0.75)
        } else {
            (INDIRECT, 0.4)
        };
        (0..3).for_each(|c| pixel[c] += (color[c] - pixel[c]) * share);
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_appear_at_their_place() {
        let mut shown = Image::new(640, 320);
        let lights = [
            ([0.25, 0.5], LightKind::Direct),
            ([0.75, 0.5], LightKind::Indirect),
        ];
        draw_lights(&mut shown, lights.into_iter());
        let near = |a: [f32; 3], b: [f32; 3]| (0..3).all(|c| (a[c] - b[c]).abs() < 1e-5);
        assert!(near(shown.at(160, 160), DIRECT), "{:?}", shown.at(160, 160));
        assert!(
            near(shown.at(480, 160), INDIRECT),
            "{:?}",
            shown.at(480, 160)
        );
    }

    #[test]
    fn emissive_texels_turn_red() {
        let own = LightPictures {
            map: Image::new(2, 1),
            lights: Vec::new(),
            emissive: [1].into(),
        };
        let shown = tinted(&own);
        assert!(shown.pixels[0][2] > shown.pixels[0][0]);
        assert!(shown.pixels[1][0] > shown.pixels[1][2]);
    }
}
