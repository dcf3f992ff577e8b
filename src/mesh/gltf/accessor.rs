//! Arrays of numbers in the buffers of a glTF file (glTF 2.0, chapter 3.6).

use crate::mesh::error::Fault;
use crate::mesh::gltf::document::{Accessor, GltfDocument};
use std::borrow::Cow;

/// The type of a component: its code, its size in bytes, the number that stands for 1 where it is normalised, and how
/// it is read.
struct ComponentType {
    code: u32,
    size: usize,
    one: f64,
    read: fn([u8; 4]) -> f64,
}

const COMPONENT_TYPES: [ComponentType; 6] = [
    ComponentType { code: 5120, size: 1, one: 127.0, read: |[a, ..]| f64::from(a as i8) },
    ComponentType { code: 5121, size: 1, one: 255.0, read: |[a, ..]| f64::from(a) },
    ComponentType { code: 5122, size: 2, one: 32767.0, read: |[a, b, ..]| f64::from(i16::from_le_bytes([a, b])) },
    ComponentType { code: 5123, size: 2, one: 65535.0, read: |[a, b, ..]| f64::from(u16::from_le_bytes([a, b])) },
    ComponentType { code: 5125, size: 4, one: 1.0, read: |bytes| f64::from(u32::from_le_bytes(bytes)) },
    ComponentType { code: 5126, size: 4, one: 1.0, read: |bytes| f64::from(f32::from_le_bytes(bytes)) },
];
/// The codes that indices may have.
const INDEX_CODES: [u32; 3] = [5121, 5123, 5125];

/// The names of accessors of one, two and three components.
const SHAPES: [&str; 3] = ["SCALAR", "VEC2", "VEC3"];

/// The arrays of a file.
pub(super) struct Accessors<'f> {
    pub(super) document: &'f GltfDocument,
    pub(super) buffers: &'f [Cow<'f, [u8]>],
}

impl<'f> Accessors<'f> {
    /// The accessor of an index.
    pub(super) fn get(&self, index: usize) -> Result<&'f Accessor, Fault> {
        self.document
            .accessors
            .get(index)
            .ok_or_else(|| Fault::new(format!("there is no accessors[{index}]: the file has {}", self.document.accessors.len())))
    }

    /// The number of elements of an accessor. It is not larger than the file.
    pub(super) fn count(&self, index: usize) -> Result<usize, Fault> {
        let accessor = self.get(index)?;
        let bytes: u64 = self.buffers.iter().map(|buffer| buffer.len() as u64).sum();
        if accessor.count > bytes {
            let count = accessor.count;
            return Err(Fault::new(format!("accessors[{index}] has {count} elements, but the buffers have {bytes} bytes")));
        }
        Ok(accessor.count as usize)
    }

    /// Gives the elements of an accessor with `N` components, with their numbers. Elements that are stored sparsely
    /// come a second time, after the others.
    pub(super) fn each<const N: usize>(
        &self,
        index: usize,
        mut give: impl FnMut(usize, [f64; N]) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        let accessor = self.get(index)?;
        let name = format!("accessors[{index}]");
        if accessor.shape != SHAPES[N - 1] {
            return Err(Fault::new(format!("{name} is of the type `{}`, and `{}` is needed", accessor.shape, SHAPES[N - 1])));
        }
        let component = component_type(accessor.component_type, &name)?;
        let count = self.count(index)?;
        let element = |bytes: &[u8]| -> [f64; N] {
            std::array::from_fn(|place| {
                let mut four = [0; 4];
                four[..component.size].copy_from_slice(&bytes[place * component.size..][..component.size]);
                let number = (component.read)(four);
                if accessor.normalized { (number / component.one).max(-1.0) } else { number }
            })
        };
        let size = component.size * N;
        match accessor.buffer_view {
            Some(view) => {
                let (bytes, stride) = self.elements(view, accessor.byte_offset, size, count, &name)?;
                for number in 0..count {
                    give(number, element(&bytes[number * stride..][..size]))?;
                }
            }
            None => (0..count).try_for_each(|number| give(number, [0.0; N]))?,
        }
        let Some(sparse) = &accessor.sparse else { return Ok(()) };
        if sparse.count > accessor.count {
            return Err(Fault::new(format!("{name} replaces {} of {count} elements", sparse.count)));
        }
        let replaced = sparse.count as usize;
        if !INDEX_CODES.contains(&sparse.indices.component_type) {
            return Err(Fault::new(format!("the sparse indices of {name} are not of an unsigned type")));
        }
        let index_type = component_type(sparse.indices.component_type, &name)?;
        let places = &sparse.indices;
        let (indices, step) = self.elements(places.buffer_view, places.byte_offset, index_type.size, replaced, &name)?;
        let (values, stride) = self.elements(sparse.values.buffer_view, sparse.values.byte_offset, size, replaced, &name)?;
        for number in 0..replaced {
            let mut four = [0; 4];
            four[..index_type.size].copy_from_slice(&indices[number * step..][..index_type.size]);
            let place = (index_type.read)(four) as usize;
            if place >= count {
                return Err(Fault::new(format!("{name} replaces its element {place}, and it has {count}")));
            }
            give(place, element(&values[number * stride..][..size]))?;
        }
        Ok(())
    }

    /// Gives the indices of an accessor.
    pub(super) fn each_index(&self, index: usize, mut give: impl FnMut(u32) -> Result<(), Fault>) -> Result<(), Fault> {
        let accessor = self.get(index)?;
        if !INDEX_CODES.contains(&accessor.component_type) || accessor.sparse.is_some() || accessor.normalized {
            return Err(Fault::new(format!("accessors[{index}] holds no indices of vertices"))
                .help("indices are unsigned whole numbers of 8, 16 or 32 bits"));
        }
        self.each(index, |_, [number]: [f64; 1]| give(number as u32))
    }

    /// The bytes of elements of this size in a buffer view, from `offset` on, and the distance from one to the next.
    fn elements(&self, view: usize, offset: u64, size: usize, count: usize, name: &str) -> Result<(&'f [u8], usize), Fault> {
        let place = format!("bufferViews[{view}]");
        let views = &self.document.buffer_views;
        let view = views.get(view).ok_or_else(|| Fault::new(format!("{name} needs {place}: the file has {}", views.len())))?;
        let buffer = self.buffers.get(view.buffer);
        let buffer = buffer.ok_or_else(|| Fault::new(format!("{place} needs buffers[{}], which is missing", view.buffer)))?;
        let range =
            |start: u64, length: u64| Some(usize::try_from(start).ok()?..usize::try_from(start.checked_add(length)?).ok()?);
        let bytes = range(view.byte_offset, view.byte_length).and_then(|range| buffer.get(range));
        let bytes = bytes.ok_or_else(|| Fault::new(format!("{place} does not fit into its buffer of {} bytes", buffer.len())))?;
        let stride = view.byte_stride.unwrap_or(size as u64);
        if stride < size as u64 {
            return Err(Fault::new(format!("{place} has elements of {size} bytes every {stride} bytes")));
        }
        let length = match count as u64 {
            0 => Some(0),
            count => stride.checked_mul(count - 1).and_then(|start| start.checked_add(size as u64)),
        };
        let found = length.and_then(|length| bytes.get(range(offset, length)?));
        let found = found.ok_or_else(|| {
            Fault::new(format!("{name} has {count} elements, which do not fit into {place} of {} bytes", bytes.len()))
        })?;
        Ok((found, stride as usize))
    }
}

fn component_type(code: u32, name: &str) -> Result<&'static ComponentType, Fault> {
    let found = COMPONENT_TYPES.iter().find(|component| component.code == code);
    found.ok_or_else(|| Fault::new(format!("{name} has components of the unknown type {code}")))
}
