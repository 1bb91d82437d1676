//! Layers of OpenEXR files.

use super::error::MAX_PIXELS;
use super::exr_picture::{PictureLayer, picture_of};
use super::exr_write::ATTRIBUTE;
use super::guard::{decoded, exr_bytes_a_byte, holds};
use super::primaries::to_rec709;
use super::{Attributes, Image, ImageError, Layer, Plane, Samples, Size};
use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, EnvironmentMap, IntegerBounds};
use exr::prelude::{AnyChannel, FlatSamples, ReadChannels, ReadLayers};
use glam::DVec3;
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;

type Part = exr::prelude::Layer<exr::prelude::AnyChannels<FlatSamples>>;

/// Everything an EXR file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LayeredImage {
    /// In the order of the file: per part, the unnamed layer first, then by name.
    pub layers: Vec<Layer>,
    /// Provenance and other text and numbers of the file's head.
    pub attributes: Attributes,
    /// Red, green, blue and white in CIE xy, if the file has them. The pixels are as they are stored.
    pub chromaticities: Option<[[f32; 2]; 4]>,
    /// What was made of data windows that are not the display window.
    pub window: Option<String>,
    /// Width of a pixel over its height.
    pub pixel_aspect: f32,
    /// Whether it holds the six sides of a cube around a place.
    pub cube: bool,
}

impl LayeredImage {
    /// The layer of that name, if there is one.
    pub fn layer(&self, name: &str) -> Option<&Layer> {
        self.layers.iter().find(|layer| layer.name == name)
    }
}

/// Reads every layer of an EXR file (f16, f32 or u32 samples, any compression).
///
/// `name.R name.G name.B` becomes a colour layer, any other channel `name.X` a gray one called
/// `name.X` (or `name` for `Y`); a part's own name comes before that of its channels. The picture
/// that is read is the display window, black where there is no data. Deep data, subsampled channels and damaged files
/// are errors.
pub fn read_layers(path: &Path) -> Result<LayeredImage, ImageError> {
    let bytes = crate::files::read(path).map_err(|source| ImageError::io(path, source))?;
    decode_layers(path, &bytes)
}

pub(super) fn decode_layers(path: &Path, bytes: &[u8]) -> Result<LayeredImage, ImageError> {
    check_headers(path, bytes)?;
    let read = || {
        exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .all_layers()
            .all_attributes()
            .from_buffered(Cursor::new(bytes))
            .map_err(|error| error.to_string())
    };
    let file = decoded(read).map_err(|why| ImageError::decode(path, "EXR", why))?;
    let chromaticities = file.attributes.chromaticities.map(|c| {
        let place = |at: exr::math::Vec2<f32>| [at.x(), at.y()];
        [c.red, c.green, c.blue, c.white].map(place)
    });
    let mut picture = LayeredImage {
        chromaticities,
        pixel_aspect: file.attributes.pixel_aspect,
        ..LayeredImage::default()
    };
    let only_part = file.layer_data.len() == 1;
    for part in &file.layer_data {
        let part_name = match &part.attributes.layer_name {
            Some(name) if !only_part => decode_text(name.as_slice()),
            _ => String::new(),
        };
        let mut layers = layers_of(path, part, &part_name)?;
        let frame = Frame {
            display: file.attributes.display_window,
            data: part.absolute_bounds(),
        };
        if !frame.is_full() {
            let note = frame.fill(&mut layers);
            picture.window = Some(note.map_err(|why| ImageError::decode(path, "EXR", why))?);
        }
        picture.layers.extend(layers);
        picture.cube |= part.attributes.environment_map == Some(EnvironmentMap::Cube);
        gather_attributes(&mut picture.attributes, part);
    }
    Ok(picture)
}

/// What part of a picture a file holds.
struct Frame {
    display: IntegerBounds,
    data: IntegerBounds,
}

impl Frame {
    fn is_full(&self) -> bool {
        self.display == self.data
    }

    /// Puts layers of the data window into the display window; says so.
    fn fill(&self, layers: &mut [Layer]) -> Result<String, String> {
        let sizes = [self.data, self.display].map(|window| window.size);
        let [data, display] = sizes.map(|size| [size.width(), size.height()]);
        let shift = [
            i64::from(self.display.position.x()) - i64::from(self.data.position.x()),
            i64::from(self.display.position.y()) - i64::from(self.data.position.y()),
        ];
        let shown = |axis: usize| {
            let end = shift[axis] + display[axis] as i64;
            end.min(data[axis] as i64) - shift[axis].max(0)
        };
        if shown(0) <= 0 || shown(1) <= 0 {
            return Err("its data window lies outside of its display window".into());
        }
        // Of a pixel of the display window, in the data.
        let place = |i: usize| {
            let x = (i % display[0]) as i64 + shift[0];
            let y = (i / display[0]) as i64 + shift[1];
            let inside = (0..data[0] as i64).contains(&x) && (0..data[1] as i64).contains(&y);
            inside.then(|| y as usize * data[0] + x as usize)
        };
        let count = display[0] * display[1];
        for layer in layers {
            match &mut layer.samples {
                Samples::Color(image) => {
                    let pixel = |i| place(i).map_or([0.0; 3], |at: usize| image.pixels[at]);
                    image.pixels = (0..count).map(pixel).collect();
                    [image.width, image.height] = display;
                }
                Samples::Gray(plane) => {
                    let value = |i| place(i).map_or(0.0, |at: usize| plane.values[at]);
                    plane.values = (0..count).map(value).collect();
                    [plane.width, plane.height] = display;
                }
            }
        }
        Ok(format!(
            "the data window of {}x{} pixels is put into the display window of {}x{}: black outside, cut off beyond",
            data[0], data[1], display[0], display[1]
        ))
    }
}

/// A picture of an EXR file.
pub(super) struct ExrPicture {
    /// Linear Rec.709.
    pub image: Image,
    /// How many of its pixels are not opaque.
    pub translucent: usize,
    /// See [`LayeredImage::window`].
    pub window: Option<String>,
    /// What the file says of its pixels that is not followed.
    pub unheeded: Vec<String>,
    /// See [`LayeredImage::cube`].
    pub cube: bool,
}

/// The picture of an EXR file.
///
/// It is the layer of this name; without a name the unnamed colour layer, else the one that is called like a finished picture
/// (`Combined`, `beauty`, …), else the only colour layer, else a gray one (`Y`, or the only layer if it is not one of depth,
/// alpha or ids), spread over R, G and B.
pub(super) fn decode_picture(
    path: &Path,
    layer: Option<&str>,
    bytes: &[u8],
) -> Result<ExrPicture, ImageError> {
    let file = decode_layers(path, bytes)?;
    let found = match layer {
        Some(name) => {
            let index = file.layers.iter().position(|layer| layer.name == name);
            index.map(PictureLayer::of)
        }
        None => picture_of(path, &file.layers)?,
    };
    let Some(PictureLayer { index, passed_over }) = found else {
        let names: Vec<_> = file
            .layers
            .iter()
            .map(|layer| layer.name.as_str())
            .collect();
        let path = path.to_owned();
        let found = names.join(", ");
        return Err(match layer {
            Some(layer) => ImageError::NoLayer {
                path,
                layer: layer.to_owned(),
                found,
            },
            None => ImageError::NoColor { path, found },
        });
    };
    let chosen = &file.layers[index];
    if let Some(others) = other_parts_of(&file, chosen) {
        let reason = format!(
            "`Y` is a part of a colour with {others}, which is not read: save it as R, G and B"
        );
        return Err(ImageError::decode(path, "EXR", reason));
    }
    let alpha = join(&chosen.name, "A");
    let translucent = match file.layer(&alpha).map(|layer| &layer.samples) {
        Some(Samples::Gray(plane)) => plane.values.iter().filter(|&&a| a < 1.0).count(),
        _ => 0,
    };
    let image = match &chosen.samples {
        Samples::Color(image) => image.clone(),
        Samples::Gray(plane) => Image {
            width: plane.width,
            height: plane.height,
            pixels: plane.values.iter().map(|&value| [value; 3]).collect(),
        },
    };
    let matrix = match (&file.chromaticities, &chosen.samples) {
        (Some(chromaticities), Samples::Color(_)) => {
            to_rec709(chromaticities).map_err(|reason| ImageError::decode(path, "EXR", reason))?
        }
        _ => None,
    };
    let image = match matrix {
        None => image,
        Some(matrix) => image.map(|rgb| {
            let rgb = DVec3::from(rgb.map(f64::from));
            (matrix * rgb).as_vec3().to_array()
        }),
    };
    let is_square = (file.pixel_aspect - 1.0).abs() < 1e-3;
    let aspect = file.pixel_aspect;
    let note =
        || format!("its pixels are {aspect} times as wide as high: they are taken for square");
    let odd_shape = (!is_square).then(note);
    let unheeded = odd_shape.into_iter().chain(foreign_space(&file));
    let unheeded = passed_over.into_iter().chain(unheeded).collect();
    Ok(ExrPicture {
        image,
        translucent,
        window: file.window,
        unheeded,
        cube: file.cube,
    })
}

/// Names of the colour space that is read, as programs write them, in small letters.
const LINEAR_REC709: [&str; 8] = [
    "linear",
    "scene_linear",
    "lin_srgb",
    "lin_rec709",
    "lin_rec709_scene",
    "linear rec.709 (srgb)",
    "linear srgb",
    "utility - linear - srgb",
];

/// A colour space that is named and is not Rec.709, where no chromaticities say what it is.
fn foreign_space(file: &LayeredImage) -> Option<String> {
    let mut attributes = file.attributes.iter();
    let names = ["colorspace", "oiio:colorspace"];
    let (name, space) = attributes.find_map(|(name, value)| {
        let known = names.iter().any(|known| name.eq_ignore_ascii_case(known));
        known.then_some(name).zip(value.as_str())
    })?;
    let known = LINEAR_REC709.contains(&space.trim().to_lowercase().as_str());
    (!known && file.chromaticities.is_none())
        .then(|| format!("its {name} `{space}` is left out: values are taken for linear Rec.709"))
}

/// The channels that make a colour with a luminance: of CIE XYZ, or of luminance and chroma.
fn other_parts_of(file: &LayeredImage, chosen: &Layer) -> Option<&'static str> {
    let has = |name: &str| file.layer(&join(&chosen.name, name)).is_some();
    match chosen.samples {
        Samples::Gray(_) if has("X") && has("Z") => Some("`X` and `Z`"),
        Samples::Gray(_) if has("RY") || has("BY") => Some("`RY` and `BY`"),
        _ => None,
    }
}

/// Width and height of the display window.
pub(super) fn promised_size(path: &Path) -> Option<[usize; 2]> {
    let meta = MetaData::read_from_file(path, false).ok()?;
    let display = meta.headers.first()?.shared_attributes.display_window;
    Some([display.size.width(), display.size.height()])
}

/// Pixels of a display window that a byte of a file may stand for.
const DISPLAY_A_BYTE: usize = 1024;

/// Longest side of a display window that is longer than the data.
const MAX_DISPLAY_SIDE: usize = 1 << 16;

/// Refuses absurd sizes, deep data and subsampled channels before anything is allocated.
fn check_headers(path: &Path, bytes: &[u8]) -> Result<(), ImageError> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false)
        .map_err(|error| ImageError::decode(path, "EXR", error))?;
    let is_too_large = |size: Size| {
        let area = size.width.checked_mul(size.height);
        area.is_none_or(|area| area > MAX_PIXELS)
    };
    for header in &meta.headers {
        let data = Size::new(header.layer_size.width(), header.layer_size.height());
        let Size { width, height } = data;
        if is_too_large(data) {
            return Err(ImageError::TooLarge {
                path: path.to_owned(),
                width,
                height,
            });
        }
        let channels = header.channels.list.iter();
        let sample_bytes: usize = channels.map(|c| c.sample_type.bytes_per_sample()).sum();
        let most = bytes
            .len()
            .saturating_mul(exr_bytes_a_byte(header.compression));
        let pixels = most / sample_bytes.max(1);
        holds(data, pixels, 1).map_err(|_| {
            let why = format!("{} bytes are too few for the {width}x{height} pixels that the header promises: the file is cut short", bytes.len());
            ImageError::decode(path, "EXR", why)
        })?;
        let window = header.shared_attributes.display_window.size;
        let display = Size::new(window.width(), window.height());
        let Size { width, height } = display;
        let is_absurd = |side: usize, data: usize| side > data.max(MAX_DISPLAY_SIDE);
        if is_absurd(width, data.width) || is_absurd(height, data.height) || is_too_large(display) {
            let why = format!("its display window has {width}x{height} pixels");
            return Err(ImageError::decode(path, "EXR", why));
        }
        // A small part of a large picture is usual.
        let least = (1 << 24) / DISPLAY_A_BYTE;
        holds(display, bytes.len().max(least), DISPLAY_A_BYTE)
            .map_err(|why| ImageError::decode(path, "EXR", why))?;
        if header.deep {
            return Err(ImageError::decode(path, "EXR", "deep data is not read"));
        }
        for channel in &header.channels.list {
            if channel.sampling.width() != 1 || channel.sampling.height() != 1 {
                let name = decode_text(channel.name.as_slice());
                let reason = format!("channel '{name}' is subsampled; save it as full RGB");
                return Err(ImageError::decode(path, "EXR", reason));
            }
        }
    }
    Ok(())
}

fn layers_of(path: &Path, part: &Part, part_name: &str) -> Result<Vec<Layer>, ImageError> {
    let (width, height) = (part.size.width(), part.size.height());
    let mut groups: BTreeMap<String, Vec<(String, &AnyChannel<FlatSamples>)>> = BTreeMap::new();
    for channel in &part.channel_data.list {
        if channel.sample_data.len() != width * height {
            return Err(ImageError::decode(path, "EXR", "a channel is incomplete"));
        }
        let full = join(part_name, &decode_text(channel.name.as_slice()));
        let (group, suffix) = full.rsplit_once('.').unwrap_or(("", &full));
        groups
            .entry(group.to_owned())
            .or_default()
            .push((suffix.to_owned(), channel));
    }
    let mut layers = Vec::new();
    for (group, channels) in groups {
        let find = |wanted: &str| {
            let same = |(suffix, _): &&(String, _)| suffix.eq_ignore_ascii_case(wanted);
            channels.iter().find(same).map(|(_, channel)| *channel)
        };
        let color = find("R").zip(find("G")).zip(find("B"));
        if let Some(((r, g), b)) = color {
            let image = interleave([r, g, b], Size { width, height });
            layers.push(Layer::color(group.clone(), image));
        }
        for (suffix, channel) in &channels {
            if color.is_some()
                && ["R", "G", "B"]
                    .iter()
                    .any(|c| suffix.eq_ignore_ascii_case(c))
            {
                continue;
            }
            let name = match suffix.as_str() {
                "Y" => group.clone(),
                _ => join(&group, suffix),
            };
            let values = channel.sample_data.values_as_f32().collect();
            let plane = Plane {
                width,
                height,
                values,
            };
            layers.push(Layer::gray(name, plane));
        }
    }
    Ok(layers)
}

fn interleave(channels: [&AnyChannel<FlatSamples>; 3], size: Size) -> Image {
    let mut image = Image::new(size.width, size.height);
    for (c, channel) in channels.into_iter().enumerate() {
        for (pixel, value) in image
            .pixels
            .iter_mut()
            .zip(channel.sample_data.values_as_f32())
        {
            pixel[c] = value;
        }
    }
    image
}

fn join(group: &str, name: &str) -> String {
    match group {
        "" => name.to_owned(),
        _ => format!("{group}.{name}"),
    }
}

/// EXR texts are bytes: ours are UTF-8, those of others may be Latin-1.
fn decode_text(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
    }
}

/// Our own provenance, or the texts and numbers that another program left, sorted by name.
fn gather_attributes(attributes: &mut Attributes, part: &Part) {
    let mut foreign = BTreeMap::new();
    for (name, value) in &part.attributes.other {
        let value = match value {
            AttributeValue::Text(text) => Value::from(decode_text(text.as_slice())),
            AttributeValue::F64(number) => Value::from(*number),
            AttributeValue::F32(number) => Value::from(*number),
            AttributeValue::I32(number) => Value::from(*number),
            _ => continue,
        };
        foreign.insert(decode_text(name.as_slice()), value);
    }
    if let Some(Value::String(json)) = foreign.get(ATTRIBUTE)
        && let Ok(own) = serde_json::from_str::<Attributes>(json)
    {
        attributes.extend(own);
        foreign.remove(ATTRIBUTE);
    }
    attributes.extend(foreign);
}
