//! The mean of images.

use rayon::prelude::*;

use super::Image;

/// Images added so far, in f64.
#[derive(Clone, Debug)]
pub struct ImageMean {
    width: usize,
    height: usize,
    sums: Vec<[f64; 3]>,
    count: u32,
}

impl ImageMean {
    /// No image yet.
    pub fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            sums: vec![[0.0; 3]; width * height],
            count: 0,
        }
    }

    /// Adds an image of the same size.
    ///
    /// # Panics
    ///
    /// If its size is another.
    pub fn add(&mut self, image: &Image) {
        assert_eq!((image.width, image.height), (self.width, self.height));
        self.count += 1;
        self.sums
            .par_iter_mut()
            .zip(&image.pixels)
            .with_min_len(4096)
            .for_each(|(sum, value)| (0..3).for_each(|c| sum[c] += f64::from(value[c])));
    }

    /// How many images there are.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Their mean; black without any.
    pub fn image(&self) -> Image {
        let mut image = Image::new(self.width, self.height);
        let count = f64::from(self.count.max(1));
        for (pixel, sum) in image.pixels.iter_mut().zip(&self.sums) {
            *pixel = sum.map(|s| (s / count) as f32);
        }
        image
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_image_is_black_and_small_values_are_not_lost_beside_large_ones() {
        let mut mean = ImageMean::new(2, 1);
        assert_eq!(mean.image(), Image::new(2, 1));
        for value in [1e8, 1.0, -1e8, 3.0] {
            let mut image = Image::new(2, 1);
            image.pixels[1] = [value; 3];
            mean.add(&image);
        }
        assert_eq!(mean.count(), 4);
        assert_eq!(mean.image().pixels, [[0.0; 3], [1.0; 3]]);
    }
}
