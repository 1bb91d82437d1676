//! Metrics and image files on a 1024 x 1024 pair: `cargo bench --bench metric`.

use criterion::{Criterion, criterion_group, criterion_main};
use lightbench::image::{Attributes, Image, Layer, Size, ToneCurve, read, write_exr, write_png};
use lightbench::metric::{
    CompareOptions, DEFAULT_PIXELS_PER_DEGREE, ExposureRange, Flip, compare, ms_ssim, pixel_errors,
    ssim,
};
use lightbench::sample::Rng;
use std::hint::black_box;

const SIDE: usize = 1024;

/// Smooth colours with noise on top, between 0 and about 1.
fn picture(noise: f32, seed: u64) -> Image {
    let mut image = Image::new(SIDE, SIDE);
    for (i, pixel) in image.pixels.iter_mut().enumerate() {
        let (x, y) = ((i % SIDE) as f32 / 90.0, (i / SIDE) as f32 / 70.0);
        let mut rng = Rng::new(seed, 0, i as u64, 0);
        let smooth = [x.sin(), (x + y).sin(), (y * 1.3).cos()];
        *pixel = smooth.map(|s| 0.5 + 0.4 * s + noise * (rng.next_f32() - 0.5));
    }
    image
}

fn metrics(criterion: &mut Criterion) {
    let (reference, test) = (picture(0.0, 1), picture(0.1, 2));
    let channel = |image: &Image| image.pixels.iter().map(|p| p[1]).collect::<Vec<_>>();
    let (x, y) = (channel(&reference), channel(&test));
    let flip = Flip::new(DEFAULT_PIXELS_PER_DEGREE);
    let curve = ToneCurve::Aces;
    let two = ExposureRange {
        count: 2,
        ..ExposureRange::of(&reference, curve)
    };
    let mut group = criterion.benchmark_group("metric 1024x1024");
    group.sample_size(10);
    group.bench_function("pixel errors", |b| {
        b.iter(|| pixel_errors(&reference, &test))
    });
    group.bench_function("SSIM, one channel", |b| {
        b.iter(|| ssim(&x, &y, Size::new(SIDE, SIDE)))
    });
    group.bench_function("MS-SSIM, one channel", |b| {
        b.iter(|| ms_ssim(&x, &y, Size::new(SIDE, SIDE)))
    });
    group.bench_function("LDR-FLIP", |b| b.iter(|| flip.ldr(&reference, &test)));
    group.bench_function("HDR-FLIP, two exposures", |b| {
        b.iter(|| flip.hdr(&reference, &test, two, curve));
    });
    let options = CompareOptions::default();
    group.bench_function("everything", |b| {
        b.iter(|| compare(&reference, &test, &options))
    });
    group.finish();
}

fn files(criterion: &mut Criterion) {
    let image = picture(0.1, 3);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (exr, png) = (folder.path().join("a.exr"), folder.path().join("a.png"));
    let layers = [Layer::color("beauty", image.clone())];
    let mut group = criterion.benchmark_group("file 1024x1024");
    group.sample_size(10);
    group.bench_function("write EXR", |b| {
        b.iter(|| write_exr(&exr, &layers, &Attributes::new()).expect("writes"));
    });
    group.bench_function("read EXR", |b| {
        b.iter(|| black_box(read(&exr).expect("reads")))
    });
    group.bench_function("write PNG", |b| {
        b.iter(|| write_png(&png, &image, 0.0).expect("writes"))
    });
    group.bench_function("read PNG", |b| {
        b.iter(|| black_box(read(&png).expect("reads")))
    });
    group.finish();
}

criterion_group!(benches, metrics, files);
criterion_main!(benches);
