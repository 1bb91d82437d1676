//! Pictures for figures: their size, tone and false colours, and dots on them.

use glam::Vec2;

use crate::image::{Image, Palette, Plane, Size, to_display};

/// Mixes a colour into a pixel; outside the image nothing happens.
fn blend(canvas: &mut Image, x: i64, y: i64, color: [f32; 3], cover: f32) {
    let (width, height) = (canvas.width as i64, canvas.height as i64);
    if x < 0 || y < 0 || x >= width || y >= height {
        return;
    }
    let pixel = &mut canvas.pixels[(y * width + x) as usize];
    let cover = cover.clamp(0.0, 1.0);
    for c in 0..3 {
        pixel[c] += (color[c] - pixel[c]) * cover;
    }
}

/// Draws a disc with soft edges; `center` and `radius` in pixels.
pub fn disc(canvas: &mut Image, center: Vec2, radius: f32, color: [f32; 3]) {
    let reach = radius.ceil() as i64 + 1;
    let (cx, cy) = (center.x.floor() as i64, center.y.floor() as i64);
    for y in cy - reach..=cy + reach {
        for x in cx - reach..=cx + reach {
            let distance = (x as f32 + 0.5 - center.x).hypot(y as f32 + 0.5 - center.y);
            blend(canvas, x, y, color, radius + 0.5 - distance);
        }
    }
}

/// The largest size of the same aspect that fits `most`; enlarged by whole factors only. Never
/// smaller than one pixel.
pub fn fitted_size(size: Size, most: Size) -> Size {
    let (width, height) = (size.width.max(1), size.height.max(1));
    let factor = (most.width / width).min(most.height / height);
    if factor >= 1 {
        return Size::new(width * factor, height * factor);
    }
    let scale = (most.width as f64 / width as f64).min(most.height as f64 / height as f64);
    let side = |n: usize| ((n as f64 * scale).round() as usize).max(1);
    Size::new(side(width), side(height))
}

/// The image at another size: nearest pixels when it grows, means of pixels when it shrinks.
pub fn scaled(image: &Image, size: Size) -> Image {
    let Size { width, height } = size;
    if image.pixels.is_empty() || width >= image.width && height >= image.height {
        return image.resize_nearest(width, height);
    }
    let mut out = Image::new(width, height);
    let span = |i: usize, from: usize, to: usize| {
        let first = i * from / to;
        first..((i + 1) * from).div_ceil(to).max(first + 1).min(from)
    };
    for y in 0..height {
        for x in 0..width {
            let mut sum = [0.0_f64; 3];
            let mut count = 0.0;
            for sy in span(y, image.height, height) {
                for sx in span(x, image.width, width) {
                    let pixel = image.at(sx, sy);
                    (0..3).for_each(|c| sum[c] += f64::from(pixel[c]));
                    count += 1.0;
                }
            }
            out.pixels[y * width + x] = sum.map(|s| (s / count) as f32);
        }
    }
    out
}

/// A linear image at another size, ready for display.
pub fn shown(linear: &Image, exposure: f32, size: Size) -> Image {
    to_display(&scaled(linear, size), exposure)
}

/// A plane at another size in false colours, `high` the brightest.
pub fn painted(plane: &Plane, high: f32, size: Size) -> Image {
    let image = Image {
        width: plane.width,
        height: plane.height,
        pixels: plane.values.iter().map(|&v| [v; 3]).collect(),
    };
    let scale = if high > 0.0 { 1.0 / high } else { 0.0 };
    scaled(&image, size).map(|p| Palette::Magma.color(p[0] * scale))
}

/// A colour bar of the palette, dark at the left.
pub fn color_bar(width: usize, height: usize) -> Image {
    let mut bar = Image::new(width, height);
    for y in 0..height {
        for x in 0..width {
            let value = x as f32 / (width.max(2) - 1) as f32;
            bar.pixels[y * width + x] = Palette::Magma.color(value);
        }
    }
    bar
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_keep_their_aspect_and_never_vanish() {
        let fitted = |[width, height]: [usize; 2], most: [usize; 2]| {
            let fitted = fitted_size(Size { width, height }, Size::new(most[0], most[1]));
            [fitted.width, fitted.height]
        };
        assert_eq!(fitted([320, 180], [1000, 900]), [960, 540]);
        assert_eq!(fitted([1920, 1080], [960, 900]), [960, 540]);
        assert_eq!(fitted([10_000, 1], [1000, 900]), [1000, 1]);
        assert_eq!(fitted([0, 0], [10, 10]), [10, 10]);
    }

    #[test]
    fn shrinking_keeps_the_mean_and_growing_the_pixels() {
        let mut image = Image::new(4, 2);
        image.pixels[0] = [8.0; 3];
        assert_eq!(scaled(&image, Size::new(1, 1)).pixels[0], [1.0; 3]);
        assert_eq!(scaled(&image, Size::new(8, 4)).at(1, 1), [8.0; 3]);
        assert_eq!(scaled(&Image::default(), Size::new(2, 1)), Image::new(2, 1));
    }

    #[test]
    fn discs_are_cut_at_the_border() {
        let mut canvas = Image::new(2, 2);
        disc(&mut canvas, Vec2::new(-3.0, 9.0), 1.0, [1.0; 3]);
        disc(&mut canvas, Vec2::new(2.0, 2.0), 1.0, [1.0; 3]);
        assert_eq!(canvas.at(0, 0), [0.0; 3]);
        assert!(canvas.at(1, 1)[0] > 0.5);
    }
}
