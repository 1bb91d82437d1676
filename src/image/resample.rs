//! Images at other sizes.

use super::{Image, Rect};

impl Image {
    /// A part of the image, cut at the borders; empty when it lies outside.
    pub fn crop(&self, part: Rect) -> Self {
        let left = part.x.min(self.width);
        let top = part.y.min(self.height);
        let width = part.width.min(self.width - left);
        let height = part.height.min(self.height - top);
        let pixels = (top..top + height)
            .flat_map(|y| &self.pixels[y * self.width + left..][..width])
            .copied()
            .collect();
        Self {
            width,
            height,
            pixels,
        }
    }

    /// The image at another size, each pixel taken from the nearest one; for magnified insets.
    ///
    /// An image without pixels gives a black one.
    pub fn resize_nearest(&self, width: usize, height: usize) -> Self {
        let mut resized = Self::new(width, height);
        if self.pixels.is_empty() {
            return resized;
        }
        for y in 0..height {
            for x in 0..width {
                let source = (x * self.width / width, y * self.height / height);
                resized.pixels[y * width + x] = self.at(source.0, source.1);
            }
        }
        resized
    }

    /// The image reduced by a whole factor, each pixel the mean of its `factor x factor` block;
    /// blocks at the right and bottom border may be smaller. A factor of 0 counts as 1.
    pub fn box_downsample(&self, factor: usize) -> Self {
        let factor = factor.max(1);
        let mut reduced = Self::new(self.width.div_ceil(factor), self.height.div_ceil(factor));
        for y in 0..reduced.height {
            for x in 0..reduced.width {
                let block = self.crop(Rect {
                    x: x * factor,
                    y: y * factor,
                    width: factor,
                    height: factor,
                });
                let mut sum = [0.0_f64; 3];
                for pixel in &block.pixels {
                    for (total, &value) in sum.iter_mut().zip(pixel) {
                        *total += f64::from(value);
                    }
                }
                let count = block.pixels.len() as f64;
                reduced.pixels[y * reduced.width + x] = sum.map(|total| (total / count) as f32);
            }
        }
        reduced
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Size;

    fn ramp(width: usize, height: usize) -> Image {
        let pixels = (0..width * height).map(|i| [i as f32; 3]).collect();
        Image {
            width,
            height,
            pixels,
        }
    }

    #[test]
    fn crop_is_cut_at_the_border() {
        let part = ramp(4, 3).crop(Rect::new(2, 1, Size::new(10, 10)));
        assert_eq!((part.width, part.height), (2, 2));
        assert_eq!(part.at(0, 0)[0], 6.0);
        assert_eq!(part.at(1, 1)[0], 11.0);
        let outside = Rect::new(9, 9, Size::new(1, 1));
        assert!(ramp(4, 3).crop(outside).pixels.is_empty());
    }

    #[test]
    fn nearest_magnifies_in_blocks_and_downsampling_undoes_it() {
        let image = ramp(3, 2);
        let large = image.resize_nearest(9, 6);
        assert_eq!(large.at(2, 2), image.at(0, 0));
        assert_eq!(large.at(8, 5), image.at(2, 1));
        assert_eq!(large.box_downsample(3), image);
        assert_eq!(Image::default().resize_nearest(2, 1), Image::new(2, 1));
    }

    #[test]
    fn downsampling_averages_partial_blocks() {
        let reduced = ramp(3, 1).box_downsample(2);
        assert_eq!(reduced.width, 2);
        assert_eq!(reduced.at(0, 0)[0], 0.5);
        assert_eq!(reduced.at(1, 0)[0], 2.0);
    }
}
