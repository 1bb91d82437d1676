//! Numbers out of accessors: strided, normalised, sparse.

use ::gltf::json::accessor::{Accessor, ComponentType, Type, sparse};

use super::document::{Buffers, GltfFile, named, valid};
use crate::scene::SceneError;

/// Elements of an accessor without bytes of its own, at most: a file cannot ask for any memory it likes.
const MAX_ZEROS: u64 = 1 << 26;

/// Reads accessors of a file with its buffers in memory.
pub(super) struct Accessors<'a> {
    pub file: &'a GltfFile,
    pub buffers: &'a Buffers,
}

/// Elements one after the other in a buffer.
struct Block<'a> {
    bytes: &'a [u8],
    stride: usize,
    component: ComponentType,
    normalised: bool,
}

impl Accessors<'_> {
    /// Vectors (or numbers, `N` = 1) as `f32`; integers as they are, or over their range if they are
    /// normalised. Fails on another type, and on bytes that are not there; nothing says that the values are finite.
    pub(super) fn vectors<const N: usize>(
        &self,
        index: usize,
    ) -> Result<Vec<[f32; N]>, SceneError> {
        let (accessor, place) = self.accessor(index)?;
        let component = valid(&accessor.component_type).map(|c| c.0);
        let fail = |message: String| self.file.error(&place, message);
        let kinds = [Type::Scalar, Type::Vec2, Type::Vec3, Type::Vec4];
        let fits = valid(&accessor.type_) == Some(kinds[N - 1]);
        let Some(component) = component.filter(|c| fits && *c != ComponentType::U32) else {
            return Err(fail(format!(
                "holds {}, not {N} numbers an element",
                told(accessor)
            )));
        };
        let count = self.count(accessor).map_err(fail)?;
        let block = |bytes, stride| Block {
            bytes,
            stride,
            component,
            normalised: accessor.normalized,
        };
        let mut values = match accessor.buffer_view {
            Some(view) => {
                let offset = accessor.byte_offset.map_or(0, |o| o.0);
                let (bytes, stride) = self
                    .elements([view.value() as u64, offset], count, N * component.size())
                    .map_err(fail)?;
                (0..count).map(|i| block(bytes, stride).vector(i)).collect()
            }
            None => vec![[0.0; N]; count],
        };
        if let Some(sparse) = &accessor.sparse {
            for (at, value) in self
                .replaced(sparse, count, N * component.size())
                .map_err(fail)?
            {
                values[at] = block(value, 0).vector(0);
            }
        }
        Ok(values)
    }

    /// Whether it holds whole numbers that are meant as they are, in a file that does not say so by its extensions.
    pub(super) fn is_out_of_scale(&self, index: usize) -> bool {
        let root = self.file.root();
        let quantised = root.extensions_used.iter();
        let mut quantised = quantised.filter(|name| *name == "KHR_mesh_quantization");
        let accessor = root.accessors.get(index);
        let whole = accessor.is_some_and(|accessor| {
            let component = valid(&accessor.component_type);
            !accessor.normalized && component.is_some_and(|c| c.0 != ComponentType::F32)
        });
        whole && quantised.next().is_none()
    }

    /// Whole numbers: indices of vertices.
    pub(super) fn indices(&self, index: usize) -> Result<Vec<u32>, SceneError> {
        let (accessor, place) = self.accessor(index)?;
        let fail = |message: String| self.file.error(&place, message);
        let component = valid(&accessor.component_type).map(|c| c.0).filter(|c| {
            let whole = [ComponentType::U8, ComponentType::U16, ComponentType::U32];
            valid(&accessor.type_) == Some(Type::Scalar) && whole.contains(c)
        });
        let Some(component) = component else {
            return Err(fail(format!(
                "holds {}, not unsigned indices",
                told(accessor)
            )));
        };
        let count = self.count(accessor).map_err(fail)?;
        let mut indices = match accessor.buffer_view {
            Some(view) => {
                let offset = accessor.byte_offset.map_or(0, |o| o.0);
                let (bytes, stride) = self
                    .elements([view.value() as u64, offset], count, component.size())
                    .map_err(fail)?;
                (0..count)
                    .map(|i| whole(&bytes[i * stride..], component))
                    .collect()
            }
            None => vec![0; count],
        };
        if let Some(sparse) = &accessor.sparse {
            for (at, value) in self
                .replaced(sparse, count, component.size())
                .map_err(fail)?
            {
                indices[at] = whole(value, component);
            }
        }
        Ok(indices)
    }

    fn accessor(&self, index: usize) -> Result<(&Accessor, String), SceneError> {
        match self.file.root().accessors.get(index) {
            Some(found) => Ok((found, named("accessor", index, found.name.as_deref()))),
            None => Err(self.file.error(format!("accessor {index}"), "is not there")),
        }
    }

    fn count(&self, accessor: &Accessor) -> Result<usize, String> {
        let count = accessor.count.0;
        if count == 0 {
            return Err("has no elements".into());
        }
        if accessor.buffer_view.is_none() && count > MAX_ZEROS {
            return Err(format!("has {count} elements and no bufferView"));
        }
        usize::try_from(count).map_err(|_| format!("has {count} elements, too many"))
    }

    /// The bytes of `count` elements of `size` bytes, from an offset in a buffer view, and from one to the next.
    fn elements(
        &self,
        [view, offset]: [u64; 2],
        count: usize,
        size: usize,
    ) -> Result<(&[u8], usize), String> {
        let view = view as usize;
        let bytes = self.file.view(self.buffers, view)?;
        let stride = self
            .file
            .declared_view(view)?
            .byte_stride
            .map_or(size, |s| s.0);
        if stride < size {
            return Err(format!(
                "has elements of {size} bytes, its buffer view a stride of {stride}"
            ));
        }
        let needed = (count as u64 - 1)
            .checked_mul(stride as u64)
            .and_then(|all| all.checked_add(size as u64))
            .and_then(|all| all.checked_add(offset));
        let have = bytes.len() as u64;
        match needed {
            Some(needed) if needed <= have => Ok((&bytes[offset as usize..], stride)),
            _ => Err(format!(
                "reaches beyond its buffer view: {count} elements, {stride} bytes apart from byte {offset} on, \
                 of {have} bytes"
            )),
        }
    }

    /// Where a sparse accessor replaces elements, and the bytes that it puts there.
    fn replaced(
        &self,
        sparse: &sparse::Sparse,
        count: usize,
        size: usize,
    ) -> Result<Vec<(usize, &[u8])>, String> {
        let replaced = usize::try_from(sparse.count.0).unwrap_or(usize::MAX);
        if replaced == 0 || replaced > count {
            return Err(format!("replaces {replaced} of its {count} elements"));
        }
        let (indices, values) = (&sparse.indices, &sparse.values);
        let component = valid(&indices.component_type)
            .ok_or("has sparse indices of no known type")?
            .0;
        let at = [indices.buffer_view.value() as u64, indices.byte_offset.0];
        let (index_bytes, index_stride) = self.elements(at, replaced, component.size())?;
        let at = [values.buffer_view.value() as u64, values.byte_offset.0];
        let (value_bytes, value_stride) = self.elements(at, replaced, size)?;
        (0..replaced)
            .map(|i| {
                let index = whole(&index_bytes[i * index_stride..], component) as usize;
                match index < count {
                    true => Ok((index, &value_bytes[i * value_stride..])),
                    false => Err(format!("replaces element {index}, it has {count}")),
                }
            })
            .collect()
    }
}

impl Block<'_> {
    fn vector<const N: usize>(&self, element: usize) -> [f32; N] {
        let size = self.component.size();
        let start = element * self.stride;
        std::array::from_fn(|c| {
            let bytes = &self.bytes[start + c * size..];
            let (value, range) = match self.component {
                ComponentType::F32 => {
                    return f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
                }
                ComponentType::I8 => (f32::from(bytes[0] as i8), 127.0),
                ComponentType::I16 => {
                    (f32::from(i16::from_le_bytes([bytes[0], bytes[1]])), 32767.0)
                }
                ComponentType::U8 => (f32::from(bytes[0]), 255.0),
                ComponentType::U16 => {
                    (f32::from(u16::from_le_bytes([bytes[0], bytes[1]])), 65535.0)
                }
                ComponentType::U32 => (whole(bytes, self.component) as f32, u32::MAX as f32),
            };
            // The lowest signed value is beyond −1.
            if self.normalised {
                (value / range).max(-1.0)
            } else {
                value
            }
        })
    }
}

/// An unsigned number at the start of some bytes.
fn whole(bytes: &[u8], component: ComponentType) -> u32 {
    match component {
        ComponentType::U8 => u32::from(bytes[0]),
        ComponentType::U16 => u32::from(u16::from_le_bytes([bytes[0], bytes[1]])),
        _ => u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
    }
}

/// The type of an accessor, for messages.
fn told(accessor: &Accessor) -> String {
    let word = |kind: Type| match kind {
        Type::Scalar => "SCALAR",
        Type::Vec2 => "VEC2",
        Type::Vec3 => "VEC3",
        Type::Vec4 => "VEC4",
        Type::Mat2 => "MAT2",
        Type::Mat3 => "MAT3",
        Type::Mat4 => "MAT4",
    };
    let kind = valid(&accessor.type_).map_or("?", word);
    let code = valid(&accessor.component_type).map_or(0, |c| c.0.as_gl_enum());
    format!("{kind} of component type {code}")
}
