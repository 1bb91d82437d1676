//! Where to look closer: the places where methods differ most.

use crate::image::{Plane, Rect, Size};

/// Sums over rectangles in constant time.
struct Integral {
    width: usize,
    sums: Vec<f64>,
}

impl Integral {
    fn new(plane: &Plane) -> Self {
        let width = plane.width + 1;
        let mut sums = vec![0.0; width * (plane.height + 1)];
        for y in 0..plane.height {
            let mut row = 0.0;
            for x in 0..plane.width {
                let value = f64::from(plane.values[y * plane.width + x]);
                row += if value.is_finite() { value } else { 0.0 };
                sums[(y + 1) * width + x + 1] = sums[y * width + x + 1] + row;
            }
        }
        Self { width, sums }
    }

    fn mean(&self, r: Rect) -> f64 {
        let at = |x: usize, y: usize| self.sums[y * self.width + x];
        let (right, bottom) = (r.x + r.width, r.y + r.height);
        let sum = at(right, bottom) - at(r.x, bottom) - at(right, r.y) + at(r.x, r.y);
        sum / (r.width * r.height) as f64
    }
}

/// Up to `count` windows of `size` where the mean errors of the methods lie furthest apart (or are
/// largest, for a single method), apart from one another by at least a quarter of the image.
///
/// `errors` are the methods' error maps, all of one size; without any the windows are spread along
/// the diagonal. A window that is larger than the image is cut to it.
pub fn choose(errors: &[&Plane], image: Size, size: Size, count: usize) -> Vec<Rect> {
    let (width, height) = (
        size.width.clamp(1, image.width.max(1)),
        size.height.clamp(1, image.height.max(1)),
    );
    let integrals: Vec<Integral> = errors.iter().map(|e| Integral::new(e)).collect();
    let (step_x, step_y) = ((width / 4).max(1), (height / 4).max(1));
    let mut candidates: Vec<(f64, Rect)> = Vec::new();
    for y in steps(image.height - height.min(image.height), step_y) {
        for x in steps(image.width - width.min(image.width), step_x) {
            let rect = Rect {
                x,
                y,
                width,
                height,
            };
            let means = integrals.iter().map(|i| i.mean(rect));
            let (low, high) = means.fold((f64::INFINITY, 0.0), |(l, h), m| (m.min(l), m.max(h)));
            let spread = match integrals.len() {
                0 => -((x as f64 * image.height as f64 - y as f64 * image.width as f64).abs()),
                1 => high,
                _ => high - low,
            };
            candidates.push((spread, rect));
        }
    }
    // Stable, so that ties are decided by position alone.
    candidates.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut chosen: Vec<Rect> = Vec::new();
    for (_, rect) in candidates {
        if chosen.len() == count {
            break;
        }
        if chosen.iter().all(|c| apart(*c, rect, image)) {
            chosen.push(rect);
        }
    }
    chosen.sort_by_key(|r| (r.y, r.x));
    chosen
}

/// 0, step, 2 step, … and `last` itself.
fn steps(last: usize, step: usize) -> impl Iterator<Item = usize> {
    (0..last).step_by(step).chain([last])
}

fn apart(a: Rect, b: Rect, image: Size) -> bool {
    let (dx, dy) = (a.x.abs_diff(b.x), a.y.abs_diff(b.y));
    let disjoint = dx >= a.width || dy >= a.height;
    disjoint && (dx * 4 >= image.width || dy * 4 >= image.height)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_places_that_differ() {
        let mut a = Plane::new(100, 60);
        let b = Plane::new(100, 60);
        for y in 40..48 {
            for x in 80..88 {
                a.values[y * 100 + x] = 1.0;
            }
        }
        for y in 4..12 {
            for x in 8..16 {
                a.values[y * 100 + x] = 0.5;
            }
        }
        let chosen = choose(&[&a, &b], Size::new(100, 60), Size::new(16, 16), 2);
        assert_eq!(chosen.len(), 2);
        let holds = |r: &Rect, x: usize, y: usize| {
            (r.x..r.x + r.width).contains(&x) && (r.y..r.y + r.height).contains(&y)
        };
        assert!(
            holds(&chosen[0], 12, 8) && holds(&chosen[1], 84, 44),
            "{chosen:?}"
        );
    }

    #[test]
    fn odd_images_get_what_fits() {
        let one = Plane::new(1, 1);
        let whole = Rect {
            x: 0,
            y: 0,
            width: 1,
            height: 1,
        };
        assert_eq!(
            choose(&[&one], Size::new(1, 1), Size::new(40, 40), 3),
            [whole]
        );
        let strip = Plane::new(500, 1);
        let chosen = choose(&[&strip, &strip], Size::new(500, 1), Size::new(40, 40), 3);
        assert_eq!(chosen.len(), 3);
        assert!(chosen.iter().all(|r| r.x + r.width <= 500 && r.height == 1));
        let mut broken = Plane::new(50, 50);
        broken.values.fill(f32::NAN);
        assert_eq!(
            choose(&[&broken], Size::new(50, 50), Size::new(10, 10), 2).len(),
            2
        );
        assert_eq!(
            choose(&[], Size::new(100, 100), Size::new(10, 10), 3).len(),
            3
        );
    }
}
