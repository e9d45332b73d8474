//! Accessors: typed arrays in buffers.
//!
//! Elements are read one by one, so that vertices which no triangle names cost nothing. Everything that an accessor declares is
//! compared with its buffer first; after that, no element is out of bounds.

use super::super::error::Mistake;
use super::buffers::Buffers;
use super::json;
use std::collections::HashMap;

/// Array of up to four numbers an element.
pub struct Accessor<'a> {
    /// Number of elements.
    pub count: usize,
    /// Numbers of an element.
    pub width: usize,
    component: Component,
    is_normalized: bool,
    /// First byte of each element, and their distance; none if all are zero.
    bytes: Option<(&'a [u8], usize)>,
    /// Elements that differ from those.
    replaced: HashMap<usize, &'a [u8]>,
}

/// Type of a number.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn parse(code: u32, place: &str) -> Result<Self, Mistake> {
        Ok(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return Err(Mistake::new(place, format!("{code} is not a component type"))),
        })
    }
    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }
}

impl<'a> Accessor<'a> {
    /// Loads the buffers of an accessor.
    pub fn load(index: usize, root: &json::Root, buffers: &mut Buffers) -> Result<(), Mistake> {
        let place = place(index);
        let accessor = find(index, root)?;
        let sparse = accessor.sparse.iter().flat_map(|s| [s.indices.buffer_view, s.values.buffer_view]);
        accessor.buffer_view.into_iter().chain(sparse).try_for_each(|view| {
            if let Some(extension) = root.buffer_views.get(view).and_then(|view| view.extensions.keys().next()) {
                let problem = format!("buffer view {view} is compressed by {extension}, which is not supported");
                return Err(Mistake::with_remedy(&place, problem, "export it without compression"));
            }
            buffers.load_view(view, &place)
        })
    }

    /// Checks an accessor whose buffers are loaded.
    pub fn new(index: usize, root: &json::Root, buffers: &'a Buffers) -> Result<Self, Mistake> {
        let place = place(index);
        let json = find(index, root)?;
        let component = Component::parse(json.component_type, &place)?;
        let width = match json.kind.as_str() {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            kind => {
                return Err(Mistake::new(
                    place,
                    format!("type {} is not that of an attribute", super::shortened(kind)),
                ));
            }
        };
        let size = width * component.size();
        let bytes = match json.buffer_view {
            None => None,
            Some(view) => {
                let (bytes, stride) = buffers.view(view, &place)?;
                let stride = stride.unwrap_or(size);
                Some((elements(bytes, json.byte_offset, json.count, stride, size, &place)?, stride))
            }
        };
        let replaced = match &json.sparse {
            None => HashMap::new(),
            Some(sparse) => replacements(sparse, json.count, size, buffers, &place)?,
        };
        Ok(Self { count: json.count, width, component, is_normalized: json.normalized, bytes, replaced })
    }

    /// Number of elements that a sparse accessor replaces.
    pub fn replaced_count(&self) -> usize {
        self.replaced.len()
    }

    /// Reports 32-bit floats or normalized integers, which attributes other than positions must be.
    pub fn is_real(&self) -> bool {
        self.component == Component::F32 || self.is_normalized
    }

    /// Element below the count, as numbers; unused ones are zero.
    pub fn numbers(&self, index: usize) -> [f32; 4] {
        let bytes = self.element(index);
        std::array::from_fn(|k| match bytes {
            Some(bytes) if k < self.width => self.number(&bytes[k * self.component.size()..]),
            _ => 0.0,
        })
    }

    /// Element below the count, as an index.
    pub fn index(&self, index: usize) -> u32 {
        let Some(bytes) = self.element(index) else { return 0 };
        match self.component {
            Component::U8 | Component::I8 => u32::from(bytes[0]),
            Component::U16 | Component::I16 => u32::from(u16::from_le_bytes([bytes[0], bytes[1]])),
            Component::U32 | Component::F32 => u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
        }
    }

    /// Reports a type that indices may have.
    pub fn is_indices(&self) -> bool {
        self.width == 1 && matches!(self.component, Component::U8 | Component::U16 | Component::U32)
    }

    fn element(&self, index: usize) -> Option<&'a [u8]> {
        let plain = || self.bytes.map(|(bytes, stride)| &bytes[index * stride..]);
        self.replaced.get(&index).copied().or_else(plain)
    }

    fn number(&self, bytes: &[u8]) -> f32 {
        let normalized =
            |value: f32, largest: f32| if self.is_normalized { (value / largest).max(-1.0) } else { value };
        match self.component {
            Component::I8 => normalized((bytes[0] as i8).into(), 127.0),
            Component::U8 => normalized(bytes[0].into(), 255.0),
            Component::I16 => normalized(i16::from_le_bytes([bytes[0], bytes[1]]).into(), 32767.0),
            Component::U16 => normalized(u16::from_le_bytes([bytes[0], bytes[1]]).into(), 65535.0),
            Component::U32 => u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]) as f32,
            Component::F32 => f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
        }
    }
}

fn place(index: usize) -> String {
    format!("accessor {index}")
}

fn find(index: usize, root: &json::Root) -> Result<&json::Accessor, Mistake> {
    root.accessors.get(index).ok_or_else(|| Mistake::new(place(index), "it does not exist"))
}

/// Bytes from the first element on, if all are within.
fn elements<'a>(
    bytes: &'a [u8],
    offset: usize,
    count: usize,
    stride: usize,
    size: usize,
    place: &str,
) -> Result<&'a [u8], Mistake> {
    if stride < size {
        return Err(Mistake::new(place, format!("elements of {size} bytes are only {stride} bytes apart")));
    }
    let length = count.checked_sub(1).map_or(Some(0), |before| before.checked_mul(stride)?.checked_add(size));
    let rest = bytes.get(offset..);
    let within = rest.filter(|rest| length.is_some_and(|length| length <= rest.len()));
    within.ok_or_else(|| {
        let problem =
            format!("{count} elements at byte {offset} are beyond the {} bytes of the buffer view", bytes.len());
        Mistake::new(place, problem)
    })
}

/// Elements that a sparse accessor replaces.
fn replacements<'a>(
    sparse: &json::Sparse,
    count: usize,
    size: usize,
    buffers: &'a Buffers,
    place: &str,
) -> Result<HashMap<usize, &'a [u8]>, Mistake> {
    let component = Component::parse(sparse.indices.component_type, place)?;
    let (bytes, _) = buffers.view(sparse.indices.buffer_view, place)?;
    let step = component.size();
    let indices = elements(bytes, sparse.indices.byte_offset, sparse.count, step, step, place)?;
    let (bytes, _) = buffers.view(sparse.values.buffer_view, place)?;
    let values = elements(bytes, sparse.values.byte_offset, sparse.count, size, size, place)?;
    let entry = |k: usize| {
        let bytes = &indices[k * step..];
        let index = (0..step).rev().fold(0, |index, byte| index << 8 | usize::from(bytes[byte]));
        (index < count).then_some((index, &values[k * size..]))
    };
    let entries = (0..sparse.count).map(entry).collect::<Option<HashMap<_, _>>>();
    entries.ok_or_else(|| Mistake::new(place, "a sparse index is beyond the elements"))
}
