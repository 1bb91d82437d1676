//! The look of methods in plots: colours and markers.

use glam::Vec2;

use super::font::Fonts;

/// Size of common text of plots, units of the sheet, to which markers and strokes belong.
pub const EM: f32 = 18.0;

/// Colours that stay apart for the colour-blind (Petroff 2021, "Accessible color sequences for data visualization"),
/// by the position of a method in the config.
const COLORS: [[u8; 3]; 10] = [
    [63, 144, 218],
    [255, 169, 14],
    [189, 31, 1],
    [148, 164, 162],
    [131, 45, 182],
    [169, 107, 89],
    [231, 99, 0],
    [185, 172, 112],
    [113, 117, 129],
    [146, 218, 221],
];

/// The colour of the method at a position in the config.
pub fn color(index: usize) -> [f32; 3] {
    COLORS[index % COLORS.len()].map(|v| f32::from(v) / 255.0)
}

/// How much larger strokes and markers are drawn, so that they suit the text.
pub fn unit(fonts: &Fonts) -> f32 {
    fonts.em / EM
}

/// The outline of a method's marker around a place, at a scale.
pub fn marker(index: usize, at: Vec2, scale: f32) -> Vec<Vec2> {
    let corners = outline(index).into_iter();
    corners
        .map(|(dx, dy)| Vec2::new(at.x + scale * dx as f32, at.y + scale * dy as f32))
        .collect()
}

/// Corners of a method's marker around the origin. As many outlines as colours and one more: both repeat
/// together only after all their pairs.
fn outline(index: usize) -> Vec<(i32, i32)> {
    match index % (COLORS.len() + 1) {
        0 => wheel(16, [6.0; 2]),
        1 => vec![(-5, -5), (5, -5), (5, 5), (-5, 5)],
        2 => vec![(0, -7), (7, 5), (-7, 5)],
        3 => vec![(0, -8), (8, 0), (0, 8), (-8, 0)],
        4 => vec![(0, 7), (7, -5), (-7, -5)],
        5 => {
            let plus = [(-2, -7), (2, -7), (2, -2), (7, -2), (7, 2), (2, 2)];
            let rest = plus.map(|(x, y)| (-x, -y));
            plus.into_iter().chain(rest).collect()
        }
        6 => wheel(10, [9.0, 3.6]),
        7 => {
            let cross = [(-6, -4), (-4, -6), (0, -2), (4, -6), (6, -4), (2, 0)];
            let rest = cross.map(|(x, y)| (-x, -y));
            cross.into_iter().chain(rest).collect()
        }
        8 => vec![(-6, -7), (6, -7), (-6, 7), (6, 7)],
        9 => vec![(-7, 0), (5, -7), (5, 7)],
        _ => wheel(8, [9.0, 3.0]),
    }
}

/// Corners around a circle, the first on top, at two radii in turn.
fn wheel(corners: u32, radii: [f64; 2]) -> Vec<(i32, i32)> {
    let corner = |i: u32| {
        let angle = f64::from(i) * std::f64::consts::TAU / f64::from(corners);
        let radius = radii[(i % 2) as usize];
        let (sin, cos) = angle.sin_cos();
        (
            (radius * sin).round() as i32,
            -(radius * cos).round() as i32,
        )
    };
    (0..corners).map(corner).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::srgb_decode;

    /// Colours as they are seen by most people, without red, green and blue cones (Machado et al. 2009), linear.
    const SEEN: [[[f32; 3]; 3]; 4] = [
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        [
            [0.152, 1.053, -0.205],
            [0.115, 0.786, 0.099],
            [-0.004, -0.048, 1.052],
        ],
        [
            [0.367, 0.861, -0.228],
            [0.280, 0.673, 0.047],
            [-0.012, 0.043, 0.969],
        ],
        [
            [1.256, -0.077, -0.179],
            [-0.078, 0.931, 0.148],
            [0.005, 0.691, 0.304],
        ],
    ];

    /// Oklab, in which distances are about as large as they look.
    fn oklab(rgb: [f32; 3]) -> [f32; 3] {
        let dot = |w: [f32; 3], v: [f32; 3]| w[0] * v[0] + w[1] * v[1] + w[2] * v[2];
        let cones = [
            [0.412_221, 0.536_333, 0.051_446],
            [0.211_903, 0.680_7, 0.107_397],
            [0.088_302, 0.281_719, 0.629_979],
        ];
        let lms = cones.map(|w| dot(w, rgb).cbrt());
        [
            [0.210_454, 0.793_618, -0.004_072],
            [1.977_998, -2.428_592, 0.450_594],
            [0.025_904, 0.782_772, -0.808_676],
        ]
        .map(|w| dot(w, lms))
    }

    #[test]
    fn ten_methods_are_told_apart_whatever_cones_one_has() {
        for (kind, matrix) in SEEN.iter().enumerate() {
            let seen = COLORS.map(|c| {
                let rgb = c.map(|v| srgb_decode(f32::from(v) / 255.0));
                let mix =
                    |w: &[f32; 3]| (w[0] * rgb[0] + w[1] * rgb[1] + w[2] * rgb[2]).clamp(0.0, 1.0);
                oklab([mix(&matrix[0]), mix(&matrix[1]), mix(&matrix[2])])
            });
            for (i, a) in seen.iter().enumerate() {
                for (j, b) in seen.iter().enumerate().skip(i + 1) {
                    let apart = (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f32>().sqrt();
                    assert!(apart > 0.055, "{kind}: {i} and {j}, {apart}");
                }
            }
        }
    }

    #[test]
    fn no_look_comes_twice_among_a_hundred_methods() {
        let looks = (0..100).map(|i| (COLORS[i % COLORS.len()], outline(i)));
        let looks: std::collections::HashSet<_> = looks.collect();
        assert_eq!(looks.len(), 100);
    }
}
