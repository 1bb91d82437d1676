//! Complex indices of refraction of named conductors, per linear Rec.709 channel.

/// Name, η and k. Derived from tabulated measurements as Mitsuba's and Tungsten's names have them.
const CONDUCTORS: [(&str, [f32; 3], [f32; 3]); 13] = [
    ("a-C", [2.9441, 2.2272, 1.9682], [0.8874, 0.7993, 0.8153]),
    ("Ag", [0.1553, 0.1167, 0.1384], [4.8283, 3.1222, 2.1471]),
    (
        "Al",
        [1.65746, 0.880369, 0.521229],
        [9.22387, 6.26952, 4.837],
    ),
    ("Au", [0.1431, 0.3750, 1.4425], [3.9832, 2.3857, 1.6032]),
    ("Be", [4.1851, 3.1851, 2.7841], [3.8354, 3.0101, 2.8690]),
    ("Cr", [4.3697, 2.9167, 1.6547], [5.2064, 4.2314, 3.7549]),
    (
        "Cu",
        [0.200438, 0.924033, 1.10221],
        [3.91295, 2.45285, 2.14219],
    ),
    ("Hg", [2.3989, 1.4400, 0.9096], [6.3276, 4.3719, 3.4218]),
    ("Ir", [3.0864, 2.0822, 1.6179], [5.5922, 4.0672, 3.2673]),
    ("Mo", [4.4837, 3.5255, 2.7761], [4.1111, 3.4209, 3.1506]),
    ("Rh", [2.5858, 1.8602, 1.5544], [6.7823, 4.7030, 3.9761]),
    ("V", [4.2775, 3.5132, 2.7611], [3.4912, 2.8894, 3.1117]),
    ("W", [4.3707, 3.3003, 2.9983], [3.5007, 2.6049, 2.2732]),
];

/// η and k of a named conductor (`Al`, `Cu_palik`, ...); `none` is the perfect mirror (0, 0). `None`
/// for names that the table lacks.
pub(super) fn conductor(name: &str) -> Option<([f32; 3], [f32; 3])> {
    if name == "none" {
        return Some(([0.0; 3], [0.0; 3]));
    }
    let symbol = name.split('_').next().unwrap_or(name);
    CONDUCTORS
        .iter()
        .find(|(n, ..)| n.eq_ignore_ascii_case(symbol))
        .map(|&(_, eta, k)| (eta, k))
}

/// Indices of refraction of named dielectrics.
const DIELECTRICS: [(&str, f64); 23] = [
    ("vacuum", 1.0),
    ("helium", 1.000_036),
    ("hydrogen", 1.000_132),
    ("air", 1.000_277),
    ("carbon dioxide", 1.000_45),
    ("water ice", 1.31),
    ("water", 1.333),
    ("acetone", 1.36),
    ("ethanol", 1.361),
    ("fused quartz", 1.458),
    ("carbon tetrachloride", 1.461),
    ("pyrex", 1.470),
    ("glycerol", 1.4729),
    ("acrylic glass", 1.49),
    ("polypropylene", 1.49),
    ("benzene", 1.501),
    ("bk7", 1.5046),
    ("silicone oil", 1.52045),
    ("sodium chloride", 1.544),
    ("amber", 1.55),
    ("pet", 1.575),
    ("bromine", 1.661),
    ("diamond", 2.419),
];

/// Index of refraction of a named dielectric.
pub(super) fn dielectric(name: &str) -> Option<f64> {
    DIELECTRICS
        .iter()
        .find(|(n, _)| n.eq_ignore_ascii_case(name))
        .map(|&(_, ior)| ior)
}

/// The names that [`dielectric`] knows.
pub(super) fn dielectric_names() -> Vec<&'static str> {
    DIELECTRICS.iter().map(|(n, _)| *n).collect()
}
