//! Lists of vectors and numbers in buffers (glTF 2.0, section 3.6.2).

use super::container::Container;
use super::document::{Accessor, MEND, named};
use super::texture_transform::TextureTransform;
use crate::error::{Fault, room};
use snowgrain_math::DVec3;

/// What numbers are stored as.
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
    fn from_code(code: u32) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The number at the start of `bytes`, which hold one.
    fn number(self, bytes: &[u8]) -> f64 {
        match (self, bytes) {
            (Self::I8, &[a, ..]) => f64::from(a.cast_signed()),
            (Self::U8, &[a, ..]) => f64::from(a),
            (Self::I16, &[a, b, ..]) => f64::from(i16::from_le_bytes([a, b])),
            (Self::U16, &[a, b, ..]) => f64::from(u16::from_le_bytes([a, b])),
            (Self::U32, &[a, b, c, d, ..]) => f64::from(u32::from_le_bytes([a, b, c, d])),
            (Self::F32, &[a, b, c, d, ..]) => f64::from(f32::from_le_bytes([a, b, c, d])),
            _ => f64::NAN,
        }
    }

    /// The number that a normalised integer stands for (glTF 2.0, section 3.11).
    fn normalised(self, number: f64) -> f64 {
        match self {
            Self::I8 => (number / 127.0).max(-1.0),
            Self::U8 => number / 255.0,
            Self::I16 => (number / 32_767.0).max(-1.0),
            Self::U16 => number / 65_535.0,
            Self::U32 | Self::F32 => number,
        }
    }
}

/// Elements of `width` numbers, `stride` bytes apart.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    component: Component,
    count: usize,
}

impl<'a> Elements<'a> {
    /// Those of a view from `offset` on, all of which it holds.
    fn of(
        container: &'a Container,
        (view, offset): (usize, u64),
        (component, width): (Component, usize),
        count: u64,
        owner: &str,
    ) -> Result<Self, Fault> {
        let (view, bytes) = container.view(view, owner)?;
        let size = (component.bytes() * width) as u64;
        let stride = view.byte_stride.unwrap_or(size);
        if stride < size {
            let what = format!("{owner} has elements of {size} bytes every {stride} bytes");
            return Err(Fault::whole(what, MEND));
        }
        let end = match count.checked_sub(1) {
            None => Some(offset),
            Some(steps) => steps
                .checked_mul(stride)
                .and_then(|length| length.checked_add(offset)?.checked_add(size)),
        };
        if end.is_none_or(|end| end > bytes.len() as u64) {
            let what = format!(
                "{owner} claims {count} elements, more than its bufferView of {} bytes holds",
                bytes.len()
            );
            return Err(Fault::whole(what, MEND));
        }
        // All of these are within the bytes now, but for a step that is never made.
        Ok(Self {
            bytes: &bytes[offset as usize..],
            stride: usize::try_from(stride).unwrap_or(usize::MAX),
            component,
            count: count as usize,
        })
    }

    fn number(&self, element: usize, place: usize) -> f64 {
        let at = element * self.stride + place * self.component.bytes();
        self.component.number(&self.bytes[at..])
    }

    fn vector<const N: usize>(&self, element: usize, normalised: bool) -> [f64; N] {
        std::array::from_fn(|place| {
            let number = self.number(element, place);
            if normalised { self.component.normalised(number) } else { number }
        })
    }
}

/// The positions of an accessor that `owner` names, in the file's unit; they may not be finite.
pub(super) fn positions(
    container: &Container,
    index: usize,
    owner: &str,
) -> Result<Vec<DVec3>, Fault> {
    vectors(container, index, (owner, "VEC3"), DVec3::from_array)
}

/// The places in a picture, moved, of an accessor that `owner` names, to the right and upwards; they may not be
/// finite.
pub(super) fn places(
    container: &Container,
    index: usize,
    transform: &TextureTransform,
    owner: &str,
) -> Result<Vec<[f32; 2]>, Fault> {
    let place = |coordinates| {
        let [u, v] = transform.apply(coordinates);
        [u as f32, (1.0 - v) as f32]
    };
    vectors(container, index, (owner, "VEC2"), place)
}

/// The vectors of N numbers of an accessor of this type.
fn vectors<const N: usize, Vector: Clone>(
    container: &Container,
    index: usize,
    (owner, kind): (&str, &str),
    vector: impl Fn([f64; N]) -> Vector,
) -> Result<Vec<Vector>, Fault> {
    let (accessor, own) = accessor(container, index, kind, owner)?;
    let component = component(accessor.component_type, &own)?;
    let mut vectors = room(claimed(container, accessor, &own)?, "vertices")?;
    match accessor.buffer_view {
        Some(view) => {
            let place = (view, accessor.byte_offset);
            let elements = Elements::of(container, place, (component, N), accessor.count, &own)?;
            let of = |i| vector(elements.vector(i, accessor.normalized));
            vectors.extend((0..elements.count).map(of));
        }
        None => vectors.resize(accessor.count as usize, vector([0.0; N])),
    }
    if let Some(sparse) = &accessor.sparse {
        let own = format!("{own}.sparse");
        let (indices, values) = (&sparse.indices, &sparse.values);
        let kind = index_component(indices.component_type, &own)?;
        let place = (indices.buffer_view, indices.byte_offset);
        let indices = Elements::of(container, place, (kind, 1), sparse.count, &own)?;
        let place = (values.buffer_view, values.byte_offset);
        let values = Elements::of(container, place, (component, N), sparse.count, &own)?;
        for i in 0..indices.count {
            let replaced = indices.number(i, 0) as usize;
            let count = vectors.len();
            let Some(place) = vectors.get_mut(replaced) else {
                let what = format!("{own} replaces element {replaced} of {count}");
                return Err(Fault::whole(what, MEND));
            };
            *place = vector(values.vector(i, accessor.normalized));
        }
    }
    Ok(vectors)
}

/// The indices of an accessor that `owner` names.
pub(super) fn indices(container: &Container, index: usize, owner: &str) -> Result<Vec<u32>, Fault> {
    let (accessor, own) = accessor(container, index, "SCALAR", owner)?;
    let component = index_component(accessor.component_type, &own)?;
    let (Some(view), None) = (accessor.buffer_view, &accessor.sparse) else {
        return Err(Fault::whole(format!("{own} holds indices, but no plain list"), MEND));
    };
    let place = (view, accessor.byte_offset);
    let elements = Elements::of(container, place, (component, 1), accessor.count, &own)?;
    let mut indices = room(elements.count, "indices")?;
    indices.extend((0..elements.count).map(|i| elements.number(i, 0) as u32));
    Ok(indices)
}

/// An accessor of elements of this type, and how messages call it.
fn accessor<'a>(
    container: &'a Container,
    index: usize,
    kind: &str,
    owner: &str,
) -> Result<(&'a Accessor, String), Fault> {
    let accessor = named(&container.document.accessors, "accessors", index, owner)?;
    let own = format!("accessors[{index}] ({owner})");
    if accessor.kind == kind {
        return Ok((accessor, own));
    }
    let given: String = accessor.kind.chars().take(20).collect();
    Err(Fault::whole(format!("{own} holds {given:?}, not {kind:?}"), MEND))
}

/// The number of elements, if the buffers can stand for as many: a list without a view of its own is
/// all zeros and takes no bytes, but each element that is used has an index of at least one.
fn claimed(container: &Container, accessor: &Accessor, own: &str) -> Result<usize, Fault> {
    let most = container.buffer_bytes();
    let count = usize::try_from(accessor.count).ok().filter(|_| accessor.count <= most);
    count.ok_or_else(|| {
        let what = format!("{own} claims {} elements in {most} bytes of buffers", accessor.count);
        Fault::whole(what, MEND)
    })
}

fn component(code: u32, own: &str) -> Result<Component, Fault> {
    let unknown = || Fault::whole(format!("{own} has the unknown componentType {code}"), MEND);
    Component::from_code(code).ok_or_else(unknown)
}

fn index_component(code: u32, own: &str) -> Result<Component, Fault> {
    match component(code, own)? {
        unsigned @ (Component::U8 | Component::U16 | Component::U32) => Ok(unsigned),
        Component::I8 | Component::I16 | Component::F32 => {
            let what = format!("{own} holds indices that are not unsigned integers");
            Err(Fault::whole(what, MEND))
        }
    }
}
