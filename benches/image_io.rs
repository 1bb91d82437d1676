//! Writing and reading the pictures of a job: layered EXR and PNG at 1024 × 1024.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use lightbench::image::{Attributes, Image, Layer, Plane, read, read_layers, write_exr, write_png};

const SIDE: usize = 1024;

/// A smooth picture with fine detail, so that compression has something to do.
fn picture() -> Image {
    let mut image = Image::new(SIDE, SIDE);
    for (i, pixel) in image.pixels.iter_mut().enumerate() {
        let (x, y) = ((i % SIDE) as f32 / 64.0, (i / SIDE) as f32 / 64.0);
        *pixel = [
            x.sin() * y.cos() * 0.5 + 0.5,
            (x * y).sin().abs(),
            (x + y).fract(),
        ];
    }
    image
}

fn image_io(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().expect("temporary folder");
    let (exr, png) = (folder.path().join("a.exr"), folder.path().join("a.png"));
    let image = picture();
    let flip = Plane {
        width: SIDE,
        height: SIDE,
        values: image.pixels.iter().map(|p| p[0]).collect(),
    };
    let layers = [
        Layer::color("beauty", image.clone()),
        Layer::gray("flip", flip),
    ];
    let mut group = criterion.benchmark_group("image_io_1024");
    group.sample_size(10);
    group.bench_function("write_exr_2_layers", |b| {
        b.iter(|| write_exr(&exr, black_box(&layers), &Attributes::new()).expect("written"));
    });
    group.bench_function("read_exr_2_layers", |b| {
        b.iter(|| read_layers(black_box(&exr)).expect("read"));
    });
    group.bench_function("write_png", |b| {
        b.iter(|| write_png(&png, black_box(&image), 0.0).expect("written"));
    });
    group.bench_function("read_png", |b| {
        b.iter(|| read(black_box(&png)).expect("read"))
    });
    group.finish();
}

criterion_group!(benches, image_io);
criterion_main!(benches);
