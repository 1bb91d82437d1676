//! Every reader against damaged files: no panic, no hang, whatever the bytes. `fuzz/` has the same readers as targets of
//! cargo-fuzz. More inputs: `LIGHTBENCH_MUTATIONS=100000 cargo test --release --test readers`.

use std::cell::Cell;
use std::fs;
use std::io::{Cursor, Write};
use std::path::Path;
use std::time::{Duration, Instant};

use lightbench::readers::{formats, read};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};

/// Longest that a reader may take for a small file, of a processor's time.
const LONGEST: Duration = Duration::from_secs(2);

/// Processor time of this thread, so that waiting for a processor does not count.
fn busy() -> Duration {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Duration::new(now.tv_sec as u64, now.tv_nsec as u32)
}

/// Small sound files of a format.
fn seeds(format: &str) -> Vec<Vec<u8>> {
    let file = |path: &str| {
        let path = format!("{}/{path}", env!("CARGO_MANIFEST_DIR"));
        fs::read(&path).unwrap_or_else(|e| panic!("{path}: {e}"))
    };
    let text = |text: &str| text.as_bytes().to_vec();
    match format {
        "config" => vec![
            file("configs/checks/stability.toml"),
            file("configs/ours/environment.toml"),
        ],
        "override" => ["caches=10..40..10", "size=[4,2]", "scale=1/4", "a.b=1,2,x"]
            .map(text)
            .to_vec(),
        "scene-toml" => vec![
            file("scenes/hard-cases/scene.toml"),
            file("scenes/table/scene.toml"),
        ],
        "mitsuba" => vec![
            file("tests/cases/textured-lamp.xml"),
            file("tests/cases/normal-map.xml"),
            file("tests/foreign/room.xml"),
            file("tests/foreign/metals.xml"),
            file("tests/foreign/lights.xml"),
        ],
        "gltf" => vec![file("tests/gltf/room.gltf"), file("tests/gltf/moving.gltf")],
        "obj" => vec![text(
            "mtllib a.mtl\no box\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0 1 0 0\nvt 0 0\nvn 0 0 1\nusemtl red\nf 1/1/1 2/1/1 3//1\nf -4 -3 \\\n-2 -1\ng b\nf 1 2 3 # c\n",
        )],
        "mtl" => vec![text(
            "newmtl red\nKd 0.8 0.1 0.1\nKs 0.1 0.1 0.1\nNs 40\nd 0.5\nTr 0.5\nillum 2\nmap_Kd -s 2 2 1 -o 0.5 0 0 a.png\nnewmtl lamp\nKe 4 4 4\n",
        )],
        "ply" => vec![ascii_ply(), binary_ply()],
        "serialized" => vec![serialized()],
        "texture" => pictures(&[
            image::ImageFormat::Png,
            image::ImageFormat::Jpeg,
            image::ImageFormat::Bmp,
            image::ImageFormat::Tga,
        ]),
        "image" => {
            let mut all = pictures(&[image::ImageFormat::Png, image::ImageFormat::Jpeg]);
            all.extend([
                file("configs/checks/hard-maps/one-row.exr"),
                file("configs/checks/hard-maps/negative.exr"),
                radiance(),
            ]);
            all
        }
        other => panic!("`{other}` has no seeds: add some"),
    }
}

fn ascii_ply() -> Vec<u8> {
    b"ply\nformat ascii 1.0\ncomment c\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 255 0 0\n1 0 0 0 255 0\n0 1 0 0 0 255\n3 0 1 2\n".to_vec()
}

fn binary_ply() -> Vec<u8> {
    let mut bytes = b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar uint vertex_index\nend_header\n".to_vec();
    for x in [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
        bytes.extend(x.to_le_bytes());
    }
    bytes.push(3);
    (0..3u32).for_each(|i| bytes.extend(i.to_le_bytes()));
    bytes
}

/// One triangle in Mitsuba's binary format.
fn serialized() -> Vec<u8> {
    let mut data = 0x1000_u32.to_le_bytes().to_vec();
    data.extend(b"name\0");
    data.extend(3_u64.to_le_bytes());
    data.extend(1_u64.to_le_bytes());
    for x in [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
        data.extend(x.to_le_bytes());
    }
    (0..3u32).for_each(|i| data.extend(i.to_le_bytes()));
    let mut bytes = vec![0x1c, 0x04, 0x04, 0x00];
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::none());
    encoder.write_all(&data).expect("memory");
    bytes.extend(encoder.finish().expect("memory"));
    bytes.extend(0_u64.to_le_bytes());
    bytes.extend(1_u32.to_le_bytes());
    bytes
}

fn pictures(formats: &[image::ImageFormat]) -> Vec<Vec<u8>> {
    let picture = image::RgbImage::from_fn(20, 12, |x, y| {
        image::Rgb([x as u8 * 12, y as u8 * 20, (x * y) as u8])
    });
    let picture = image::DynamicImage::from(picture);
    let written = |format: &image::ImageFormat| {
        let mut bytes = Cursor::new(Vec::new());
        picture.write_to(&mut bytes, *format).expect("memory");
        bytes.into_inner()
    };
    formats.iter().map(written).collect()
}

fn radiance() -> Vec<u8> {
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\n\n-Y 4 +X 4\n".to_vec();
    (0..64u8).for_each(|i| bytes.push(120 + i % 20));
    bytes
}

/// One thing that happens to a file; places are shares of its length.
#[derive(Clone, Debug)]
enum Damage {
    Set(f64, u8),
    Insert(f64, Vec<u8>),
    Word(f64, &'static str),
    Remove(f64, usize),
    Repeat(f64, usize, usize),
    Cut(f64),
    /// The next number from there on becomes a word.
    Number(f64, &'static str),
}

fn damage() -> impl Strategy<Value = Damage> {
    let words = [
        "-1",
        "0",
        "1e999",
        "nan",
        "4294967295",
        "99999999999999999999",
        "\"",
        "<",
        "/",
        "[[",
        "$a",
        "..",
        "\0",
        "\n",
        "property list",
        "usemtl x\n",
    ];
    let numbers = [
        "-1",
        "0",
        "1",
        "-0.0",
        "1e39",
        "1e-45",
        "1e308",
        "nan",
        "-inf",
        "2",
        "3",
        "255",
        "65536",
        "2147483648",
        "4294967295",
        "18446744073709551615",
        "0.5",
        "\"x\"",
        "[]",
    ];
    let at = || 0.0..1.0;
    prop_oneof![
        4 => (at(), any::<u8>()).prop_map(|(a, b)| Damage::Set(a, b)),
        1 => (at(), proptest::collection::vec(any::<u8>(), 1..9)).prop_map(|(a, b)| Damage::Insert(a, b)),
        2 => (at(), proptest::sample::select(words.to_vec())).prop_map(|(a, w)| Damage::Word(a, w)),
        1 => (at(), 1usize..40).prop_map(|(a, n)| Damage::Remove(a, n)),
        1 => (at(), 1usize..40, 2usize..60).prop_map(|(a, n, k)| Damage::Repeat(a, n, k)),
        1 => at().prop_map(Damage::Cut),
        4 => (at(), proptest::sample::select(numbers.to_vec())).prop_map(|(a, w)| Damage::Number(a, w)),
    ]
}

fn damaged(mut bytes: Vec<u8>, all: &[Damage]) -> Vec<u8> {
    for one in all {
        let place = |share: &f64| (share * bytes.len() as f64) as usize;
        match one {
            Damage::Set(share, value) => {
                let at = place(share);
                if let Some(byte) = bytes.get_mut(at) {
                    *byte = *value;
                }
            }
            Damage::Insert(share, more) => {
                let at = place(share);
                bytes.splice(at..at, more.iter().copied());
            }
            Damage::Word(share, word) => {
                let at = place(share);
                let end = (at + word.len()).min(bytes.len());
                bytes.splice(at..end, word.bytes());
            }
            Damage::Remove(share, count) => {
                let at = place(share);
                let end = (at + count).min(bytes.len());
                bytes.drain(at..end);
            }
            Damage::Repeat(share, count, times) => {
                let at = place(share);
                let end = (at + count).min(bytes.len());
                let again = bytes[at..end].repeat(*times);
                bytes.splice(at..at, again);
            }
            Damage::Cut(share) => bytes.truncate(place(share)),
            Damage::Number(share, word) => {
                let is_part = |byte: &u8| byte.is_ascii_digit() || b"+-.eE".contains(byte);
                let mut from = bytes.iter().enumerate().skip(place(share));
                if let Some((at, _)) = from.find(|(_, byte)| byte.is_ascii_digit()) {
                    let length = bytes[at..].iter().take_while(|byte| is_part(byte)).count();
                    bytes.splice(at..at + length, word.bytes());
                }
            }
        }
    }
    bytes
}

#[test]
fn sound_files_are_read() {
    for format in formats() {
        for seed in seeds(format) {
            read(format, &seed).unwrap_or_else(|told| panic!("{format}: {told}"));
        }
    }
}

/// `LIGHTBENCH_SEEDS=fuzz/corpus cargo test --test readers seeds` writes them where cargo-fuzz begins from.
#[test]
fn seeds_are_written_where_they_are_wanted() {
    let Some(folder) = std::env::var_os("LIGHTBENCH_SEEDS") else {
        return;
    };
    for format in formats() {
        let folder = Path::new(&folder).join(format);
        fs::create_dir_all(&folder).expect("a folder");
        for (number, seed) in seeds(format).into_iter().enumerate() {
            fs::write(folder.join(format!("seed-{number}")), seed).expect("a file");
        }
    }
}

#[test]
fn damaged_files_are_refused_or_read_soon_and_without_a_panic() {
    let cases = std::env::var("LIGHTBENCH_MUTATIONS").ok();
    let cases = cases.map_or(60, |text| text.parse().expect("a number of inputs"));
    // `LIGHTBENCH_FORMATS=obj,mtl` reads these alone.
    let chosen = std::env::var("LIGHTBENCH_FORMATS").ok();
    let is_chosen = |format: &&str| {
        let chosen = chosen.as_deref();
        chosen.is_none_or(|all| all.split(',').any(|one| one == *format))
    };
    for format in formats().filter(is_chosen) {
        let strategy = (
            proptest::sample::select(seeds(format)),
            proptest::collection::vec(damage(), 1..12),
        );
        let config = Config {
            cases,
            failure_persistence: None,
            ..Config::default()
        };
        let (start, longest) = (Instant::now(), Cell::new(Duration::ZERO));
        let outcome = TestRunner::new(config).run(&strategy, |(seed, all)| {
            let bytes = damaged(seed, &all);
            let start = busy();
            let _ = read(format, &bytes);
            let took = busy() - start;
            longest.set(longest.get().max(took));
            prop_assert!(took < LONGEST, "{} bytes took {took:?}", bytes.len());
            Ok(())
        });
        let (took, longest) = (start.elapsed(), longest.get());
        eprintln!("{format}: {cases} files in {took:.1?}, the longest {longest:.1?}");
        if let Err(found) = outcome {
            panic!("{format}: {found}");
        }
    }
}
