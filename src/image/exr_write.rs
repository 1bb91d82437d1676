//! Layers and attributes as OpenEXR files.

use super::{Attributes, ImageError, Layer, Samples, write_atomically};
use exr::meta::attribute::AttributeValue;
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, LayerAttributes,
    LineOrder, Text, WritableImage,
};
use std::path::Path;

/// The attribute that carries [`Attributes`] as one JSON text: a single attribute keeps the bytes
/// of a file reproducible, where the order of several would be random.
pub(super) const ATTRIBUTE: &str = "lightbench";

/// Writes layers of equal size as one EXR part of f32 channels, losslessly compressed; equal input
/// gives equal bytes.
///
/// The first layer is the picture (channels `R G B`, or `Y`), whatever its name; every further one
/// becomes `name.R name.G name.B` or `name.Y`. Fails, with nothing written, when there is no layer,
/// a layer is empty or differs in size, or two names coincide.
pub fn write_exr(path: &Path, layers: &[Layer], attributes: &Attributes) -> Result<(), ImageError> {
    let (width, height) = common_size(path, layers)?;
    let mut layer_attributes = LayerAttributes {
        software_name: Text::new_or_none("lightbench"),
        ..LayerAttributes::default()
    };
    if !attributes.is_empty() {
        let json = serde_json::to_string(attributes).map_err(|e| ImageError::encode(path, e))?;
        layer_attributes.other.insert(
            Text::from(ATTRIBUTE),
            AttributeValue::Text(Text::from_slice_unchecked(json.as_bytes())),
        );
    }
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let channels = AnyChannels::sort(
        layers
            .iter()
            .enumerate()
            .flat_map(|(index, layer)| channels_of(index, layer))
            .collect(),
    );
    let part = exr::prelude::Layer::new((width, height), layer_attributes, encoding, channels);
    let picture = exr::prelude::Image::from_layer(part);
    write_atomically(path, |writer| {
        picture
            .write()
            .to_buffered(writer)
            .map_err(|error| match error {
                exr::error::Error::Io(source) => ImageError::io(path, source),
                other => ImageError::encode(path, other),
            })
    })
}

fn common_size(path: &Path, layers: &[Layer]) -> Result<(usize, usize), ImageError> {
    let first = layers
        .first()
        .ok_or_else(|| ImageError::encode(path, "no layers were given"))?;
    let (width, height) = first.size();
    if width == 0 || height == 0 {
        let reason = format!("an EXR file cannot hold {width}x{height} pixels");
        return Err(ImageError::encode(path, reason));
    }
    for (index, layer) in layers.iter().enumerate() {
        if layer.size() != (width, height) || layer.value_count() != width * height {
            let (w, h) = layer.size();
            let count = layer.value_count();
            let name = &layer.name;
            let reason = format!(
                "layer '{name}' has {w}x{h} pixels ({count} stored), the first {width}x{height}"
            );
            return Err(ImageError::encode(path, reason));
        }
        let named_before = || {
            layers[1..index]
                .iter()
                .any(|other| other.name == layer.name)
        };
        if index > 0 && (layer.name.is_empty() || named_before()) {
            let reason = format!("layer name '{}' is empty or given twice", layer.name);
            return Err(ImageError::encode(path, reason));
        }
    }
    Ok((width, height))
}

fn channels_of(index: usize, layer: &Layer) -> Vec<AnyChannel<FlatSamples>> {
    let prefix = match index {
        0 => String::new(),
        _ => format!("{}.", layer.name),
    };
    let channel = |suffix: &str, values: Vec<f32>| {
        let name = format!("{prefix}{suffix}");
        AnyChannel::new(
            Text::from_slice_unchecked(name.as_bytes()),
            FlatSamples::F32(values),
        )
    };
    match &layer.samples {
        Samples::Color(image) => ["R", "G", "B"]
            .iter()
            .enumerate()
            .map(|(c, suffix)| channel(suffix, image.pixels.iter().map(|p| p[c]).collect()))
            .collect(),
        Samples::Gray(plane) => vec![channel("Y", plane.values.clone())],
    }
}
