//! What the tests of the truths share: references, small renders, and comparisons that know their
//! noise.
#![allow(dead_code, reason = "each test binary uses its own part")]

use std::path::PathBuf;

use lightbench::image::{Image, read};
use lightbench::scene::Scene;
use lightbench::shade::{Depths, PathTracer, RenderOptions, Rendering, render};
use lightbench::trace::Tracer;

/// A file below `LIGHTBENCH_REFS`, or a line that says why not.
pub fn reference_file(path: &str) -> Option<PathBuf> {
    let Some(folder) = std::env::var_os("LIGHTBENCH_REFS") else {
        println!("skipped: LIGHTBENCH_REFS is not set");
        return None;
    };
    let file = PathBuf::from(folder).join(path);
    if !file.exists() {
        println!("skipped: {} is absent", file.display());
        return None;
    }
    Some(file)
}

/// A reference image below `LIGHTBENCH_REFS`, if it is there.
pub fn reference(path: &str) -> Option<Image> {
    Some(read(&reference_file(path)?).expect("readable reference"))
}

/// A small render of the scene's first view.
pub fn small_render(scene: &Scene, [width, height]: [usize; 2], spp: u64, depth: u32) -> Rendering {
    let tracer = Tracer::new(&scene.positions, &scene.triangles);
    let path_tracer = PathTracer::new(scene, &tracer);
    let options = RenderOptions {
        width,
        height,
        samples: 0..spp,
        seed: 1,
        depths: Depths::up_to(depth),
    };
    let rendering = render(&path_tracer, &scene.views[0], &options);
    assert_eq!(rendering.non_finite, [], "non-finite samples");
    if let Some(folder) = std::env::var_os("LIGHTBENCH_TEST_IMAGES") {
        let file = PathBuf::from(folder).join(format!("{}_{depth}.png", scene.name));
        lightbench::image::write_png(&file, &rendering.mean, scene.exposure).expect("writable");
    }
    rendering
}

/// Comparison of a render with a reference of the same size, in square blocks of pixels.
#[derive(Debug)]
pub struct Agreement {
    /// Root mean square over pixels and channels of difference / standard deviation.
    pub z_rms: f64,
    /// Share of blocks whose mean differs by more than the tolerance and four standard deviations.
    pub bad_blocks: f64,
    /// The worst block: column, row, ours, theirs (mean over channels).
    pub worst: (usize, usize, f64, f64),
    /// Ours over theirs, of the whole image, per channel.
    pub ratio: [f64; 3],
    /// Standard deviation of `ratio` by the noise of both.
    pub ratio_sigma: [f64; 3],
}

/// Compares block means. `noise` is the variance of the reference per pixel and channel (an image,
/// or black where it is unknown); `relative` is the tolerance beyond noise.
pub fn agreement(
    ours: &Rendering,
    theirs: &Image,
    noise: &Image,
    [block, relative]: [f64; 2],
) -> Agreement {
    let (width, height) = (theirs.width, theirs.height);
    assert_eq!((ours.mean.width, ours.mean.height), (width, height));
    let side = block as usize;
    let (mut z2, mut z_count) = (0.0, 0.0);
    let (mut bad, mut blocks) = (0.0, 0.0);
    let mut worst = (0, 0, 0.0, 0.0);
    let mut worst_excess = -f64::INFINITY;
    let mut sums = [[0.0f64; 3]; 3];
    for top in (0..height).step_by(side) {
        for left in (0..width).step_by(side) {
            let (mut a, mut b, mut variance, mut count) = (0.0, 0.0, 0.0, 0.0);
            for y in top..(top + side).min(height) {
                for x in left..(left + side).min(width) {
                    for (c, sums) in sums.iter_mut().enumerate() {
                        let mine = f64::from(ours.mean.at(x, y)[c]);
                        let other = f64::from(theirs.at(x, y)[c]);
                        let var = f64::from(ours.variance.at(x, y)[c] + noise.at(x, y)[c]);
                        sums[0] += mine;
                        sums[1] += other;
                        sums[2] += var;
                        a += mine;
                        b += other;
                        variance += var;
                        count += 1.0;
                        if var > 0.0 {
                            z2 += ((mine - other).powi(2) / var).min(100.0);
                            z_count += 1.0;
                        }
                    }
                }
            }
            // Channels are correlated: count their deviations as one.
            let sigma = (3.0 * variance).sqrt();
            let allowed = 4.0 * sigma + relative * b + 1e-3 * count * relative;
            let excess = (a - b).abs() - allowed;
            blocks += 1.0;
            if excess > 0.0 {
                bad += 1.0;
            }
            if excess / count > worst_excess {
                worst_excess = excess / count;
                worst = (left / side, top / side, a / count, b / count);
            }
        }
    }
    Agreement {
        z_rms: (z2 / f64::max(z_count, 1.0)).sqrt(),
        bad_blocks: bad / blocks,
        worst,
        ratio: sums.map(|[a, b, _]| a / b),
        ratio_sigma: sums.map(|[_, b, var]| var.sqrt() / b),
    }
}
