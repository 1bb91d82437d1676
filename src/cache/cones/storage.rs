//! Entries in memory: in full, or in the bits of the paper (section 3.3).

use glam::Vec3;
use half::f16;

use super::surprise::Watch;
use super::{Cone, Entry, MOST_CONES};

/// How entries are written to memory, as 32-bit words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Storage {
    /// 32-bit floats: `4 + 7 n` words for up to `n` cones.
    Full {
        /// Most of an entry.
        cones: usize,
    },
    /// `10 + 92 n` bits for up to `n` cones, 286 for the paper's three: 8 for the count, 2 for the number of cones (4
    /// where they can be more than three); of each cone two 16-bit floats for the spherical coordinates of the
    /// axis, 6 for the half angle in steps of 90°/63, and three times 18 for the light: 5 of exponent and 13 of mantissa.
    /// 24 more tell whether the light has changed: two floats of 5 bits of exponent and 7 of mantissa.
    Compressed {
        /// Most of an entry.
        cones: usize,
    },
}

/// Steps of a compressed half angle.
const ANGLE_STEPS: f32 = 63.0;
/// Bits of mantissa of compressed light.
const MANTISSA: u32 = 13;
/// Bits of it that numbers without a colour do without.
const SHORTENED: u32 = 6;
/// Exponent of compressed light that stands for 1.
const BIAS: i32 = 15;
/// Largest compressed light.
const BRIGHTEST: f32 = 131_064.0;

impl Storage {
    /// Words of an entry.
    pub fn words(self) -> usize {
        match self {
            Self::Full { cones } => 4 + 7 * cones,
            Self::Compressed { .. } => self.bits().div_ceil(32),
        }
    }

    /// Bits that an entry needs.
    pub fn bits(self) -> usize {
        match self {
            Self::Full { .. } => 32 * self.words(),
            Self::Compressed { cones } => (8 + number_bits(cones) + 24) as usize + 92 * cones,
        }
    }

    /// Whether an entry has more light than can be written.
    pub fn is_too_bright(self, entry: &Entry) -> bool {
        let brightest = entry.cones().iter().map(|cone| cone.light.max_element());
        matches!(self, Self::Compressed { .. }) && brightest.fold(0.0, f32::max) > BRIGHTEST
    }

    /// Reads an entry.
    pub fn read(self, words: &[u32]) -> Entry {
        match self {
            Self::Full { cones } => read_full(words, cones),
            Self::Compressed { cones } => read_bits(words, cones),
        }
    }

    /// Writes an entry of at most as many cones.
    pub fn write(self, entry: &Entry, words: &mut [u32]) {
        words.fill(0);
        match self {
            Self::Full { .. } => write_full(entry, words),
            Self::Compressed { cones } => write_bits(entry, words, cones),
        }
    }
}

/// Bits of the number of cones.
fn number_bits(cones: usize) -> u32 {
    if cones <= 3 { 2 } else { 4 }
}

fn read_full(words: &[u32], most: usize) -> Entry {
    let mut entry = Entry {
        used: (words[0] as usize).min(most).min(MOST_CONES),
        count: f32::from_bits(words[1]),
        watch: Watch {
            recent: f32::from_bits(words[2]),
            spread: f32::from_bits(words[3]),
        },
        ..Entry::default()
    };
    for (cone, words) in entry.cones[..entry.used]
        .iter_mut()
        .zip(words[4..].chunks_exact(7))
    {
        let number = |i: usize| f32::from_bits(words[i]);
        let vector = |i: usize| Vec3::new(number(i), number(i + 1), number(i + 2));
        *cone = Cone {
            axis: vector(0),
            half_angle: number(3),
            light: vector(4),
        };
    }
    entry
}

fn write_full(entry: &Entry, words: &mut [u32]) {
    words[0] = entry.used as u32;
    words[1] = entry.count.to_bits();
    words[2] = entry.watch.recent.to_bits();
    words[3] = entry.watch.spread.to_bits();
    for (cone, words) in entry.cones().iter().zip(words[4..].chunks_exact_mut(7)) {
        let (axis, light) = (cone.axis.to_array(), cone.light.to_array());
        let numbers = axis.iter().chain([&cone.half_angle]).chain(&light);
        for (word, number) in words.iter_mut().zip(numbers) {
            *word = number.to_bits();
        }
    }
}

fn read_bits(words: &[u32], most: usize) -> Entry {
    let mut bits = Bits { words, next: 0 };
    let count = bits.take(8) as f32;
    let used = bits.take(number_bits(most)) as usize;
    let [recent, spread] = [(); 2].map(|()| unsigned_float(bits.take(12) << SHORTENED));
    let mut entry = Entry {
        used: used.min(most).min(MOST_CONES),
        count,
        watch: Watch { recent, spread },
        ..Entry::default()
    };
    for cone in &mut entry.cones[..entry.used] {
        let [theta, phi] = [(); 2].map(|()| f16::from_bits(bits.take(16) as u16).to_f32());
        let half_angle = bits.take(6) as f32 * (90.0 / ANGLE_STEPS);
        let light = [(); 3].map(|()| unsigned_float(bits.take(18)));
        let ((sine, cosine), (y, x)) = (theta.sin_cos(), phi.sin_cos());
        *cone = Cone {
            axis: Vec3::new(sine * x, sine * y, cosine),
            half_angle: half_angle.to_radians(),
            light: light.into(),
        };
    }
    entry
}

fn write_bits(entry: &Entry, words: &mut [u32], most: usize) {
    let mut next = 0;
    let mut put = |value: u32, count: u32| {
        for bit in 0..count {
            words[(next / 32) as usize] |= (value >> bit & 1) << (next % 32);
            next += 1;
        }
    };
    put(entry.count.round().clamp(0.0, 255.0) as u32, 8);
    put(entry.used as u32, number_bits(most));
    for value in [entry.watch.recent, entry.watch.spread] {
        let rounded = (unsigned_float_bits(value) + (1 << SHORTENED >> 1)) >> SHORTENED;
        put(rounded.min((1 << 12) - 1), 12);
    }
    for cone in entry.cones() {
        let axis = cone.axis;
        let theta = axis.truncate().length().atan2(axis.z);
        let phi = axis.y.atan2(axis.x);
        put(f16::from_f32(theta).to_bits().into(), 16);
        put(f16::from_f32(phi).to_bits().into(), 16);
        let step = cone.half_angle.to_degrees() * (ANGLE_STEPS / 90.0);
        put(step.round().clamp(0.0, ANGLE_STEPS) as u32, 6);
        for light in cone.light.to_array() {
            put(unsigned_float_bits(light), 18);
        }
    }
}

/// Bits of an entry, the lowest of a word first.
struct Bits<'a> {
    words: &'a [u32],
    next: u32,
}

impl Bits<'_> {
    fn take(&mut self, count: u32) -> u32 {
        let (word, offset) = ((self.next / 32) as usize, self.next % 32);
        let low = u64::from(self.words[word]);
        let high = self.words.get(word + 1).map_or(0, |w| u64::from(*w));
        self.next += count;
        ((low | high << 32) >> offset) as u32 & ((1 << count) - 1)
    }
}

/// A float without sign, of 5 bits of exponent and 13 of mantissa, with denormal numbers; rounded to the nearest, NaN
/// and negative numbers 0, too large ones the largest.
fn unsigned_float_bits(value: f32) -> u32 {
    if value.is_nan() || value <= 0.0 {
        return 0;
    }
    let value = value.min(BRIGHTEST);
    let exponent = ((value.to_bits() >> 23) as i32 - 127).max(1 - BIAS);
    let scaled = f64::from(value) * 2f64.powi(MANTISSA as i32 - exponent);
    // A mantissa that rounds up to the next power of two carries into the exponent.
    let mantissa = scaled.round() as u32;
    (((exponent + BIAS - 1) as u32) << MANTISSA) + mantissa
}

fn unsigned_float(bits: u32) -> f32 {
    let (exponent, mantissa) = (bits >> MANTISSA, bits & ((1 << MANTISSA) - 1));
    let (exponent, mantissa) = match exponent {
        0 => (1, mantissa),
        _ => (exponent, mantissa + (1 << MANTISSA)),
    };
    mantissa as f32 * 2f32.powi(exponent as i32 - BIAS - MANTISSA as i32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cache::cones::angle_between;
    use crate::sample::Rng;

    fn entry(rng: &mut Rng, cones: usize) -> Entry {
        let cone = |rng: &mut Rng| Cone {
            axis: Vec3::new(
                rng.next_f32() - 0.5,
                rng.next_f32() - 0.5,
                rng.next_f32() - 0.2,
            )
            .normalize(),
            half_angle: rng.next_f32() * 1.57,
            light: Vec3::new(
                rng.next_f32(),
                100.0 * rng.next_f32(),
                0.01 * rng.next_f32(),
            ),
        };
        let cones: Vec<Cone> = (0..cones).map(|_| cone(rng)).collect();
        Entry::of(&cones, (rng.next_f32() * 255.0).round())
    }

    #[test]
    fn three_cones_take_the_bits_of_the_paper() {
        let paper = Storage::Compressed { cones: 3 };
        assert_eq!((paper.bits(), paper.words()), (286 + 24, 10));
        let of = |light| {
            Entry::of(
                &[Cone {
                    axis: Vec3::Z,
                    half_angle: 0.1,
                    light: Vec3::Y * light,
                }],
                1.0,
            )
        };
        assert!(paper.is_too_bright(&of(2e5)) && !paper.is_too_bright(&of(BRIGHTEST)));
        assert!(!Storage::Full { cones: 3 }.is_too_bright(&of(1e20)));
        assert_eq!(Storage::Full { cones: 3 }.words(), 25);
    }

    #[test]
    fn full_entries_come_back_to_the_bit_and_compressed_ones_nearly() {
        let mut rng = Rng::new(3, 0, 0, 0);
        for cones in 1..=MOST_CONES {
            for used in 0..=cones {
                let entry = entry(&mut rng, used);
                let full = Storage::Full { cones };
                let mut words = vec![7; full.words()];
                full.write(&entry, &mut words);
                assert_eq!(full.read(&words), entry);
                let compressed = Storage::Compressed { cones };
                let mut words = vec![7; compressed.words()];
                compressed.write(&entry, &mut words);
                let back = compressed.read(&words);
                assert_eq!((back.used, back.count), (used, entry.count));
                for (a, b) in back.cones().iter().zip(entry.cones()) {
                    assert!(angle_between(a.axis, b.axis) < 2e-3, "{a:?} {b:?}");
                    assert!((a.half_angle - b.half_angle).abs() < 0.0126);
                    let off = ((a.light - b.light) / b.light).abs().max_element();
                    assert!(off < 1e-3, "{a:?} {b:?}");
                }
                // Writing again what was read changes nothing more.
                let mut again = vec![0; compressed.words()];
                compressed.write(&back, &mut again);
                let twice = compressed.read(&again);
                for (a, b) in twice.cones().iter().zip(back.cones()) {
                    assert_eq!((a.half_angle, a.light), (b.half_angle, b.light));
                }
            }
        }
    }

    #[test]
    fn compressed_light_rounds_to_the_nearest_and_keeps_to_its_range() {
        for value in [1.0, 0.5, 3.0, 1e-4, 6e-5, 1e-6, 1000.0, 65504.0, 1.999_95] {
            let back = unsigned_float(unsigned_float_bits(value));
            let allowed = (value / 16384.0).max(2f32.powi(-28));
            assert!((back - value).abs() <= allowed, "{value} {back}");
        }
        for (value, expected) in [
            (0.0, 0.0),
            (-1.0, 0.0),
            (f32::NAN, 0.0),
            (f32::INFINITY, BRIGHTEST),
            (1e9, BRIGHTEST),
        ] {
            assert_eq!(unsigned_float(unsigned_float_bits(value)), expected);
        }
        assert_eq!(unsigned_float_bits(BRIGHTEST), (1 << 18) - 1);
    }
}
