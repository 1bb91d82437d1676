//! All metrics of two images, and maps of where they differ.

use super::error::check_sizes;
use super::{
    DEFAULT_PIXELS_PER_DEGREE, ExposureRange, Flip, MetricError, absolute_error, ms_ssim,
    pixel_errors, psnr, ssim,
};
use crate::image::{
    Encoding, Image, Plane, ToneCurve, clamp_unit, decode_srgb, encode_srgb, read_picture,
    sanitise, srgb_decode,
};
use std::borrow::Cow;
use std::path::Path;

/// How two images are compared.
#[derive(Clone, Debug, PartialEq)]
pub struct CompareOptions {
    /// Scales linear images by 2^`exposure` before they are clamped for the display metrics.
    pub exposure: f32,
    /// The pixels are sRGB-coded values in `[0, 1]` rather than linear light.
    pub display_referred: bool,
    /// Whether HDR-FLIP, the costliest metric, is computed; never for display-referred images.
    pub flip_hdr: bool,
    /// The tone curve of HDR-FLIP.
    pub tone_curve: ToneCurve,
    /// FLIP's observer: pixels per degree of visual angle.
    pub pixels_per_degree: f32,
    /// Whether the per-pixel maps are kept.
    pub maps: bool,
}

impl Default for CompareOptions {
    fn default() -> Self {
        Self {
            exposure: 0.0,
            display_referred: false,
            flip_hdr: true,
            tone_curve: ToneCurve::Aces,
            pixels_per_degree: DEFAULT_PIXELS_PER_DEGREE,
            maps: false,
        }
    }
}

/// All metrics of two images; the first ten fields are the stable keys of `compare --json`.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Comparison {
    /// Root of the mean squared error: of linear values, or of coded ones when display-referred.
    pub rmse: f64,
    /// Mean of (a - r)² / (r² + 0.01), on the same values as `rmse`.
    pub relmse: f64,
    /// In dB, on display values; `None` (null) when infinite.
    pub psnr: Option<f64>,
    /// Mean over R, G, B of SSIM on display values.
    pub ssim: f64,
    /// Mean over R, G, B of MS-SSIM on display values.
    pub ms_ssim: f64,
    /// Mean of LDR-FLIP on display values.
    pub flip_ldr: f64,
    /// Mean of HDR-FLIP; `None` when not asked for or display-referred.
    pub flip_hdr: Option<f64>,
    /// First and last exposure of HDR-FLIP in stops.
    pub flip_start_exposure: Option<f64>,
    /// See `flip_start_exposure`.
    pub flip_stop_exposure: Option<f64>,
    /// Pixels with a NaN or an infinity, of both images together.
    pub non_finite: usize,
    /// Pixels with a negative value (clamped to 0), of both images together.
    pub negative: usize,
    /// Pixels that are not opaque, of both files together: their alpha is left out. 0 for images in memory.
    pub translucent: usize,
    /// What was made of the files, or is not followed of them: windows, profiles, gammas.
    #[serde(skip)]
    pub notes: Vec<String>,
    /// Mean absolute error, on the same values as `rmse`.
    pub mae: f64,
    /// Difference of the means over that of the reference, on the same values as `rmse`: what an image has too much, as a
    /// share. `None` where the reference is black.
    pub mean_error: Option<f64>,
    /// `relmse` without the worst 0.1 % of the pixels.
    pub relmse_trimmed: f64,
    /// `relmse` of display values: exposed, clamped and sRGB-coded.
    pub relmse_display: f64,
    /// SSIM and MS-SSIM of the luma 0.2126 R + 0.7152 G + 0.0722 B of display values.
    pub ssim_luma: f64,
    /// See `ssim_luma`.
    pub ms_ssim_luma: f64,
    /// Scales that MS-SSIM used: fewer than 5 when a side is below 161 pixels.
    pub ms_ssim_scales: usize,
    /// Number of exposures of HDR-FLIP.
    pub flip_exposures: Option<usize>,
    /// The tone curve of HDR-FLIP.
    pub flip_tone_curve: ToneCurve,
    /// Of visual angle: the observer of FLIP.
    pub pixels_per_degree: f32,
    /// Stops applied before the display metrics.
    pub exposure: f32,
    /// Whether `rmse` and `relmse` are on coded values.
    pub display_referred: bool,
    /// Pixels of both images.
    pub width: usize,
    /// Pixels of both images.
    pub height: usize,
    /// Per-pixel maps, when asked for.
    #[serde(skip)]
    pub maps: Option<Maps>,
}

/// Per-pixel errors.
#[derive(Clone, Debug, PartialEq)]
pub struct Maps {
    /// Absolute difference per channel, on the values of `rmse`.
    pub error: Image,
    /// LDR-FLIP, in `[0, 1]`.
    pub flip_ldr: Plane,
    /// HDR-FLIP, in `[0, 1]`.
    pub flip_hdr: Option<Plane>,
}

/// Compares a test image with a reference of the same size.
///
/// Both are sanitised first ([`crate::image::sanitise`]); no result is ever NaN, whatever they hold.
pub fn compare(
    reference: &Image,
    test: &Image,
    options: &CompareOptions,
) -> Result<Comparison, MetricError> {
    check_sizes(reference, test)?;
    check_options(options)?;
    let (mut reference, mut test) = (reference.clone(), test.clone());
    let replaced = [sanitise(&mut reference), sanitise(&mut test)];
    let errors = pixel_errors(&reference, &test);
    let displays = [
        Display::new(&reference, options),
        Display::new(&test, options),
    ];
    let structure = Structure::of([&displays[0].coded, &displays[1].coded]);
    let shown = match options.display_referred {
        true => errors,
        false => pixel_errors(&displays[0].coded, &displays[1].coded),
    };
    let flip = Flip::new(options.pixels_per_degree);
    let flip_ldr = flip.ldr(&displays[0].linear, &displays[1].linear);
    let curve = options.tone_curve;
    let range = (options.flip_hdr && !options.display_referred)
        .then(|| ExposureRange::of(&reference, curve));
    let flip_hdr = range.map(|range| flip.hdr(&reference, &test, range, curve));
    Ok(Comparison {
        rmse: errors.mse.sqrt(),
        relmse: errors.relmse,
        psnr: psnr(shown.mse),
        ssim: structure.ssim,
        ms_ssim: structure.ms_ssim,
        flip_ldr: flip_ldr.mean(),
        flip_hdr: flip_hdr.as_ref().map(Plane::mean),
        flip_start_exposure: range.map(|range| f64::from(range.start)),
        flip_stop_exposure: range.map(|range| f64::from(range.stop)),
        non_finite: replaced.iter().map(|counts| counts.non_finite).sum(),
        negative: replaced.iter().map(|counts| counts.negative).sum(),
        translucent: 0,
        notes: Vec::new(),
        mae: errors.mae,
        mean_error: errors.mean_error,
        relmse_trimmed: errors.relmse_trimmed,
        relmse_display: shown.relmse,
        ssim_luma: structure.ssim_luma,
        ms_ssim_luma: structure.ms_ssim_luma,
        ms_ssim_scales: structure.scales,
        flip_exposures: range.map(|range| range.count),
        flip_tone_curve: curve,
        pixels_per_degree: options.pixels_per_degree,
        exposure: options.exposure,
        display_referred: options.display_referred,
        width: reference.width,
        height: reference.height,
        maps: options.maps.then(|| Maps {
            error: absolute_error(&reference, &test),
            flip_ldr,
            flip_hdr,
        }),
    })
}

/// Reads and compares two files.
///
/// Two display-referred files (PNG, JPEG) are compared on their coded values; if either is linear,
/// both are compared as linear images. `options.display_referred` is set accordingly.
pub fn compare_files(
    reference: &Path,
    test: &Path,
    options: &CompareOptions,
) -> Result<Comparison, MetricError> {
    let paths = [reference, test];
    let [reference, test] = [read_picture(reference)?, read_picture(test)?];
    let translucent = reference.translucent + test.translucent;
    let notes = paths.iter().zip([&reference, &test]);
    let notes = notes
        .flat_map(|(path, picture)| {
            let pixels = picture.translucent;
            let alpha = (pixels > 0)
                .then(|| format!("{pixels} pixels are not opaque; their alpha is left out"));
            let all = picture.window.iter().chain(&picture.unheeded).cloned();
            all.chain(alpha)
                .map(|note| format!("{}: {note}", path.display()))
        })
        .collect();
    let (mut reference, reference_encoding) = (reference.image, reference.encoding);
    let (mut test, test_encoding) = (test.image, test.encoding);
    let mut options = options.clone();
    options.display_referred = [reference_encoding, test_encoding] == [Encoding::Srgb; 2];
    if !options.display_referred {
        for (image, encoding) in [
            (&mut reference, reference_encoding),
            (&mut test, test_encoding),
        ] {
            if encoding == Encoding::Srgb {
                *image = decode_srgb(image);
            }
        }
    }
    let compared = compare(&reference, &test, &options)?;
    Ok(Comparison {
        translucent,
        notes,
        ..compared
    })
}

fn check_options(options: &CompareOptions) -> Result<(), MetricError> {
    if !(1.0..=1000.0).contains(&options.pixels_per_degree) {
        return Err(MetricError::PixelsPerDegree(options.pixels_per_degree));
    }
    if !(-100.0..=100.0).contains(&options.exposure) {
        return Err(MetricError::Exposure(options.exposure));
    }
    Ok(())
}

/// What a display shows of an image: linear light in `[0, 1]`, and the same coded as sRGB.
struct Display<'a> {
    linear: Image,
    coded: Cow<'a, Image>,
}

impl<'a> Display<'a> {
    fn new(image: &'a Image, options: &CompareOptions) -> Self {
        if options.display_referred {
            return Self {
                linear: image.map(|pixel| pixel.map(|value| srgb_decode(clamp_unit(value)))),
                coded: Cow::Borrowed(image),
            };
        }
        let scale = options.exposure.exp2();
        let linear = image.map(|pixel| pixel.map(|value| clamp_unit(value * scale)));
        let coded = Cow::Owned(encode_srgb(&linear));
        Self { linear, coded }
    }
}

/// The SSIM family, over the three channels and on luma.
struct Structure {
    ssim: f64,
    ms_ssim: f64,
    ssim_luma: f64,
    ms_ssim_luma: f64,
    scales: usize,
}

impl Structure {
    fn of(pair: [&Image; 2]) -> Self {
        let size = pair[0].size();
        let measure = |value: &dyn Fn([f32; 3]) -> f32| {
            let [reference, test] =
                pair.map(|image| image.pixels.iter().map(|&p| value(p)).collect::<Vec<_>>());
            (
                ssim(&reference, &test, size),
                ms_ssim(&reference, &test, size),
            )
        };
        let channels: [_; 3] = std::array::from_fn(|c| measure(&|pixel| pixel[c]));
        let luma = measure(&crate::image::luminance);
        Self {
            ssim: channels.iter().map(|(single, _)| single).sum::<f64>() / 3.0,
            ms_ssim: channels.iter().map(|(_, multi)| multi.value).sum::<f64>() / 3.0,
            ssim_luma: luma.0,
            ms_ssim_luma: luma.1.value,
            scales: luma.1.scales,
        }
    }
}

#[cfg(test)]
#[path = "compare_tests.rs"]
mod tests;
