//! Maps made in code, by name: 1024×512, the same bits on any number of threads. Units are arbitrary
//! but for the skies, which are in W/(m² sr nm).

mod night;
mod outdoor;
mod paint;
mod room;

use crate::image::Image;

/// A map and what it provokes.
struct Entry {
    name: &'static str,
    summary: &'static str,
    image: fn() -> Image,
}

const fn entry(name: &'static str, summary: &'static str, image: fn() -> Image) -> Entry {
    Entry {
        name,
        summary,
        image,
    }
}

const GALLERY: &[Entry] = &[
    entry("noon", "a high sun in a clear sky", || {
        outdoor::sky(72.0, 2.5, true)
    }),
    entry("afternoon", "a sun at 40° in a clear sky", || {
        outdoor::sky(40.0, 3.0, true)
    }),
    entry("low-sun", "a sun at 12°: long shadows", || {
        outdoor::sky(12.0, 3.0, true)
    }),
    entry("sunset", "a sun at 2°", || outdoor::sky(2.0, 4.0, true)),
    entry("haze", "a sun at 35° in haze", || {
        outdoor::sky(35.0, 9.0, true)
    }),
    entry(
        "clear-sky",
        "the sky of a sun at 40° without its disc",
        || outdoor::sky(40.0, 3.0, false),
    ),
    entry("twilight", "the sky of a sun on the horizon", || {
        outdoor::sky(0.5, 3.0, false)
    }),
    entry("overcast", "an overcast sky", outdoor::overcast),
    entry(
        "canopy",
        "gaps of bright sky between leaves",
        outdoor::canopy,
    ),
    entry(
        "living-room",
        "a room with two windows and a lamp",
        room::living_room,
    ),
    entry("loft", "a wall of windows", room::loft),
    entry("cellar", "one slit of light in a dark vault", room::cellar),
    entry(
        "gym",
        "slender tubes under a ceiling: long narrow sources",
        room::gym,
    ),
    entry("studio", "large soft boxes", room::studio),
    entry(
        "photo-studio",
        "many small bright sources all around",
        room::photo_studio,
    ),
    entry(
        "fireside",
        "one small warm light near the floor",
        room::fireside,
    ),
    entry("night-street", "many small lamps at night", night::street),
    entry(
        "night-lamps",
        "a few small lamps far apart at night",
        night::lamps,
    ),
    entry("night-city", "lit windows and signs at night", night::city),
    entry("texel", "one bright texel in a dim surround", paint::texel),
    entry(
        "constant",
        "the same radiance from everywhere",
        paint::constant,
    ),
    entry("black", "no light at all", paint::black),
];

/// Names and summaries of the embedded maps.
pub fn embedded_maps() -> impl Iterator<Item = (&'static str, &'static str)> {
    GALLERY.iter().map(|entry| (entry.name, entry.summary))
}

/// An embedded map; `None` when there is none of this name.
pub fn embedded_map(name: &str) -> Option<Image> {
    let entry = GALLERY.iter().find(|entry| entry.name == name)?;
    Some((entry.image)())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::luminance;

    #[test]
    fn maps_are_sound_lit_and_different() {
        assert!(GALLERY.len() >= 16);
        let mut means = Vec::new();
        for entry in GALLERY {
            let image = (entry.image)();
            assert_eq!((image.width, image.height), (1024, 512), "{}", entry.name);
            let sound = |v: &f32| v.is_finite() && *v >= 0.0;
            assert!(
                image.pixels.iter().flatten().all(sound),
                "{} holds values that are no radiance",
                entry.name
            );
            let mean = image
                .pixels
                .iter()
                .map(|&p| f64::from(luminance(p)))
                .sum::<f64>();
            assert_eq!(mean == 0.0, entry.name == "black", "{}", entry.name);
            assert!(!means.contains(&mean), "{} repeats a map", entry.name);
            means.push(mean);
        }
    }
}
