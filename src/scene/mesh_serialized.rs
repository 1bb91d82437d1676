//! Mitsuba's compressed binary meshes (`.serialized`, file versions 3 and 4).
//!
//! A file is a sequence of meshes, each a 4-byte header and a zlib stream, followed by a dictionary of
//! their offsets and, in the last four bytes, their number.

use std::io::Read;
use std::path::Path;

use glam::{DVec3, Vec2};

use super::text::file_error;
use super::{Mesh, SceneError};
use crate::other_kind::with_other_kind;

/// Bytes that a name may have.
const LONGEST_NAME: usize = 4096;
/// How many times larger than its part of the file a mesh may be, and what it may have in any case, bytes: coordinates do
/// not shrink as zeros do, which a few hundred KB hold a GB of.
const MOST_EXPANSION: usize = 100;
const LEAST_EXPANSION: usize = 16 << 20;
const MAGIC: u16 = 0x041c;
const HAS_NORMALS: u32 = 0x0001;
const HAS_UVS: u32 = 0x0002;
const HAS_COLOURS: u32 = 0x0008;
const IS_DOUBLE: u32 = 0x2000;

/// Loads mesh number `index` of a file; damage is reported with the byte offset of the mesh.
pub(super) fn load_serialized(path: &Path, index: usize) -> Result<Mesh, SceneError> {
    let bytes = crate::files::read(path).map_err(|e| file_error(path, e.to_string()))?;
    parse_serialized(&bytes, index).map_err(|message| file_error(path, message))
}

/// [`load_serialized`] of the bytes of a file.
pub(super) fn parse_serialized(bytes: &[u8], index: usize) -> Result<Mesh, String> {
    let Place {
        start,
        end,
        version,
    } = locate(bytes, index)?;
    let mut stream = Stream {
        inner: flate2::read::ZlibDecoder::new(&bytes[start + 4..end]),
        left: LEAST_EXPANSION.max(MOST_EXPANSION.saturating_mul(end - start)),
    };
    stream
        .mesh(version)
        .map_err(|e| format!("mesh {index} at byte offset {start}: {e}"))
}

/// Where a mesh lies in a file.
struct Place {
    start: usize,
    end: usize,
    /// Of the file.
    version: u16,
}

fn locate(bytes: &[u8], index: usize) -> Result<Place, String> {
    let (magic, version) = header(bytes, 0)?;
    if magic != MAGIC {
        let message = "byte offset 0: not a Mitsuba serialized mesh".to_owned();
        return Err(with_other_kind(message, bytes));
    }
    if !matches!(version, 3 | 4) {
        return Err(format!(
            "byte offset 2: file version {version}, only 3 and 4 are known"
        ));
    }
    let entry = if version == 4 { 8 } else { 4 };
    let end = bytes.len().checked_sub(4).ok_or("the file is truncated")?;
    let count = integer(&bytes[end..]) as usize;
    let dictionary = count
        .checked_mul(entry)
        .and_then(|size| end.checked_sub(size))
        .filter(|&start| count > 0 && start >= 4)
        .ok_or_else(|| {
            format!("byte offset {end}: {count} meshes cannot be; the file is truncated")
        })?;
    if index >= count {
        return Err(format!(
            "mesh {index} is asked for, the file has {count} (from 0)"
        ));
    }
    let offset_of = |i: usize| integer(&bytes[dictionary + i * entry..][..entry]) as usize;
    let start = offset_of(index);
    let stop = if index + 1 < count {
        offset_of(index + 1)
    } else {
        dictionary
    };
    if stop > dictionary || stop.checked_sub(4).is_none_or(|last| start > last) {
        return Err(format!(
            "byte offset {dictionary}: the dictionary is damaged; the file is truncated"
        ));
    }
    if header(bytes, start)? != (MAGIC, version) {
        return Err(format!(
            "byte offset {start}: mesh {index} has no header; the file is damaged"
        ));
    }
    Ok(Place {
        start,
        end: stop,
        version,
    })
}

fn header(bytes: &[u8], at: usize) -> Result<(u16, u16), String> {
    match bytes.get(at..at.saturating_add(4)) {
        Some(b) => Ok((
            u16::from_le_bytes([b[0], b[1]]),
            u16::from_le_bytes([b[2], b[3]]),
        )),
        None => Err(format!("byte offset {at}: the file is truncated")),
    }
}

/// A little-endian integer of up to eight bytes.
fn integer(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .rev()
        .fold(0, |value, &b| value << 8 | u64::from(b))
}

struct Stream<R> {
    inner: R,
    /// Bytes that may still come out of it.
    left: usize,
}

impl<R: Read> Stream<R> {
    fn mesh(&mut self, version: u16) -> Result<Mesh, String> {
        let flags = integer(&self.take(4)?) as u32;
        if version == 4 {
            let mut length = 0;
            while self.take(1)?[0] != 0 {
                length += 1;
                if length > LONGEST_NAME {
                    return Err(format!(
                        "the name of the mesh is longer than {LONGEST_NAME} bytes"
                    ));
                }
            }
        }
        let vertices = self.count("vertices")?;
        let triangles = self.count("triangles")?;
        let double = flags & IS_DOUBLE != 0;
        let positions = self.numbers(vertices * 3, double)?;
        let mut mesh = Mesh {
            positions: positions.chunks_exact(3).map(DVec3::from_slice).collect(),
            ..Mesh::default()
        };
        if flags & HAS_NORMALS != 0 {
            let values = self.numbers(vertices * 3, double)?;
            mesh.normals = values
                .chunks_exact(3)
                .map(|n| DVec3::from_slice(n).as_vec3())
                .collect();
        }
        if flags & HAS_UVS != 0 {
            let values = self.numbers(vertices * 2, double)?;
            mesh.uvs = values
                .chunks_exact(2)
                .map(|t| Vec2::new(t[0] as f32, t[1] as f32))
                .collect();
        }
        if flags & HAS_COLOURS != 0 {
            let values = self.numbers(vertices * 3, double)?;
            let colour = |c: &[f64]| std::array::from_fn(|i| c[i] as f32);
            mesh.colours = values.chunks_exact(3).map(colour).collect();
        }
        let indices = self.take(triangles * 12)?;
        for triangle in indices.chunks_exact(12) {
            let corners = [0, 4, 8].map(|at| integer(&triangle[at..at + 4]) as u32);
            if corners.iter().any(|&i| i as usize >= vertices) {
                return Err(format!("a triangle names vertex {corners:?} of {vertices}"));
            }
            mesh.triangles.push(corners);
        }
        Ok(mesh)
    }

    fn count(&mut self, what: &str) -> Result<usize, String> {
        let count = integer(&self.take(8)?);
        if count > u64::from(u32::MAX) {
            return Err(format!("{count} {what} are too many; the file is damaged"));
        }
        Ok(count as usize)
    }

    fn numbers(&mut self, count: usize, double: bool) -> Result<Vec<f64>, String> {
        let size = if double { 8 } else { 4 };
        let bytes = self.take(count * size)?;
        Ok(if double {
            let value = |b: &[u8]| f64::from_bits(integer(b));
            bytes.chunks_exact(8).map(value).collect()
        } else {
            let value = |b: &[u8]| f64::from(f32::from_bits(integer(b) as u32));
            bytes.chunks_exact(4).map(value).collect()
        })
    }

    /// Exactly `count` bytes; memory grows only as far as the data goes.
    fn take(&mut self, count: usize) -> Result<Vec<u8>, String> {
        self.left = self.left.checked_sub(count).ok_or_else(|| {
            format!("the mesh would be more than {MOST_EXPANSION} times as large as its part of the file, which is damaged")
        })?;
        let mut bytes = Vec::new();
        let read = (&mut self.inner).take(count as u64).read_to_end(&mut bytes);
        read.map_err(|e| format!("the compressed data is damaged ({e})"))?;
        if bytes.len() < count {
            return Err(format!(
                "{count} bytes expected, {} found; truncated",
                bytes.len()
            ));
        }
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    /// A file of `count` meshes of one triangle at z = its number.
    fn file(version: u16, count: usize, double: bool) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut offsets = Vec::new();
        for z in 0..count {
            offsets.push(bytes.len() as u64);
            bytes.extend(MAGIC.to_le_bytes());
            bytes.extend(version.to_le_bytes());
            let mut data = Vec::new();
            let flags = HAS_UVS | if double { IS_DOUBLE } else { 0x1000 };
            data.extend(flags.to_le_bytes());
            if version == 4 {
                data.extend(b"name\0");
            }
            data.extend(3_u64.to_le_bytes());
            data.extend(1_u64.to_le_bytes());
            let z = z as f64;
            for x in [0., 0., z, 1., 0., z, 0., 1., z, 0., 0., 1., 0., 0., 1.0_f64] {
                if double {
                    data.extend(x.to_le_bytes());
                } else {
                    data.extend((x as f32).to_le_bytes());
                }
            }
            for i in [0_u32, 1, 2] {
                data.extend(i.to_le_bytes());
            }
            let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), Default::default());
            encoder.write_all(&data).unwrap();
            bytes.extend(encoder.finish().unwrap());
        }
        for offset in offsets {
            if version == 4 {
                bytes.extend(offset.to_le_bytes());
            } else {
                bytes.extend((offset as u32).to_le_bytes());
            }
        }
        bytes.extend((count as u32).to_le_bytes());
        bytes
    }

    #[test]
    fn both_versions_and_precisions_are_read() {
        for version in [3, 4] {
            for double in [false, true] {
                let mesh = parse_serialized(&file(version, 3, double), 2).unwrap();
                assert_eq!(mesh.positions[1], DVec3::new(1.0, 0.0, 2.0));
                assert_eq!(mesh.uvs[2], Vec2::Y);
                assert_eq!(mesh.triangles, [[0, 1, 2]]);
                assert!(mesh.normals.is_empty());
            }
        }
    }

    #[test]
    fn colours_are_kept() {
        let mut data = (HAS_COLOURS | 0x1000).to_le_bytes().to_vec();
        data.extend([1_u64.to_le_bytes(), 0_u64.to_le_bytes()].concat());
        let values = [0.0_f32, 0.0, 0.0, 0.25, 0.5, 0.75].map(f32::to_le_bytes);
        data.extend(values.concat());
        let mesh = Stream {
            inner: &data[..],
            left: usize::MAX,
        }
        .mesh(3)
        .unwrap();
        assert_eq!(mesh.colours, [[0.25, 0.5, 0.75]]);
    }

    #[test]
    fn every_truncation_is_refused() {
        let whole = file(4, 2, false);
        for length in 0..whole.len() {
            assert!(
                parse_serialized(&whole[..length], 0).is_err(),
                "{length} bytes"
            );
        }
    }

    #[test]
    fn places_beyond_all_numbers_are_refused() {
        let sound = file(4, 1, false);
        for offset in [u64::MAX, u64::MAX - 3, 1 << 63, sound.len() as u64] {
            let mut damaged = sound.clone();
            let at = damaged.len() - 12;
            damaged[at..at + 8].copy_from_slice(&offset.to_le_bytes());
            let error = parse_serialized(&damaged, 0).unwrap_err();
            assert!(error.contains("the dictionary is damaged"), "{error}");
        }
    }

    #[test]
    fn zeros_without_end_are_refused_before_they_are_read() {
        let (vertices, mut data) = (12_000_000_u64, 0x1000_u32.to_le_bytes().to_vec());
        data.extend(b"name\0");
        data.extend([vertices.to_le_bytes(), 1_u64.to_le_bytes()].concat());
        data.resize(data.len() + 12 * (vertices as usize + 1), 0);
        let mut bytes = [0x1c, 0x04, 0x04, 0x00].to_vec();
        let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), Default::default());
        encoder.write_all(&data).unwrap();
        bytes.extend(encoder.finish().unwrap());
        bytes.extend([0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0]);
        let error = parse_serialized(&bytes, 0).unwrap_err();
        assert!(error.contains("100 times as large"), "{error}");
    }

    #[test]
    fn errors_say_what_is_there() {
        assert_eq!(
            parse_serialized(&file(4, 2, false), 2).unwrap_err(),
            "mesh 2 is asked for, the file has 2 (from 0)"
        );
        let mut damaged = file(4, 1, false);
        damaged[12] ^= 0xff;
        let error = parse_serialized(&damaged, 0).unwrap_err();
        assert!(error.starts_with("mesh 0 at byte offset 0: "), "{error}");
        assert!(
            parse_serialized(b"PK\x03\x04....", 0)
                .unwrap_err()
                .contains("not a Mitsuba")
        );
    }
}
