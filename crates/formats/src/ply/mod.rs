//! The PLY format (Turk 1994), shared by meshes and grain files: a header that declares elements
//! and their properties, then their rows as text or in either byte order.
//!
//! Nothing is allocated by the counts of a header before they were compared with the length of the
//! file.

mod body;
mod header;

pub(crate) use body::{Body, Row};
pub(crate) use header::{Element, Encoding, Header, Scalar, Shape};
