//! Shapes in grain files: a comment for each prototype, `shape 3 cube rounding 0.5`, and in each row its number
//! and the 44 bits of the orientation, 15 to a property.

use crate::error::{Fault, Place};
use crate::mesh::single_property;
use crate::ply::{Element, Row};
use snowgrain_geometry::{GrainShape, Shape};
use snowgrain_grains::FieldShapes;
use std::io::{self, Write};

/// Declared after the radius.
pub(super) const PROPERTIES: &str = "property uchar shape\n\
     property ushort orientation_0\n\
     property ushort orientation_1\n\
     property ushort orientation_2\n";

const BITS: u32 = 15;

pub(super) fn write_prototypes(writer: &mut impl Write, prototypes: &[Shape]) -> io::Result<()> {
    prototypes
        .iter()
        .enumerate()
        .try_for_each(|(number, shape)| writeln!(writer, "comment shape {number} {}", shape.name()))
}

/// The bytes of a grain's shape.
pub(super) fn row(shape: GrainShape) -> [u8; 7] {
    let bits = shape.orientation_bits();
    let mut row = [shape.prototype() as u8; 7];
    for (place, bytes) in row[1..].chunks_exact_mut(2).enumerate() {
        let part = (bits >> (BITS * place as u32)) as u16 & ((1 << BITS) - 1);
        bytes.copy_from_slice(&part.to_le_bytes());
    }
    row
}

/// Where the shape of a grain stands in its row, and the prototypes that are declared.
pub(super) struct ShapeLayout {
    prototypes: Vec<Shape>,
    number: usize,
    orientation: [usize; 3],
}

impl ShapeLayout {
    /// `None` where grains are spheres.
    pub(super) fn of(vertex: &Element, comments: &[String]) -> Result<Option<Self>, Fault> {
        if vertex.property("shape").is_none() {
            return Ok(None);
        }
        let part = |name: &str| single_property(vertex, name);
        Ok(Some(Self {
            prototypes: prototypes(comments)?,
            number: part("shape")?,
            orientation: [part("orientation_0")?, part("orientation_1")?, part("orientation_2")?],
        }))
    }

    /// How far the grain of a row reaches, in its radii.
    pub(super) fn reach(&self, row: &Row) -> f64 {
        self.prototype(row).map_or(1.0, |index| self.prototypes[index].bounding_radius())
    }

    fn prototype(&self, row: &Row) -> Option<usize> {
        let number = row.numbers[self.number];
        (0..self.prototypes.len()).find(|&index| index as f64 == number)
    }

    /// The shape of the grain of a row.
    pub(super) fn of_row(&self, place: Place, row: &Row) -> Result<GrainShape, Fault> {
        let Some(prototype) = self.prototype(row) else {
            let what = format!("shape {} is not declared", row.numbers[self.number]);
            let mend = "declare it by a comment, as \"comment shape 0 cube rounding 0\"";
            return Err(Fault::new(place, what, mend));
        };
        let parts = self.orientation.map(|at| row.numbers[at]);
        let fits = |part: f64| (0.0..32_768.0).contains(&part) && part.fract() == 0.0;
        let bits = parts.iter().rev().fold(0, |bits, &part| bits << BITS | part as u64);
        let shape = parts.iter().all(|&part| fits(part));
        let shape = shape.then(|| GrainShape::of_orientation(prototype, bits)).flatten();
        shape.ok_or_else(|| {
            let what = format!("{parts:?} is no orientation");
            Fault::new(place, what, "use a file that Snowgrain wrote")
        })
    }

    pub(super) fn with(self, of_grains: Vec<GrainShape>) -> FieldShapes {
        FieldShapes { prototypes: self.prototypes.into(), of_grains }
    }
}

/// The prototypes that the comments declare, numbered from 0.
fn prototypes(comments: &[String]) -> Result<Vec<Shape>, Fault> {
    let mut prototypes = Vec::new();
    for comment in comments {
        let Some(declared) = comment.trim().strip_prefix("shape ") else { continue };
        let (number, name) = declared.split_once(' ').unwrap_or((declared, ""));
        if number.parse() != Ok(prototypes.len()) || prototypes.len() == GrainShape::MOST_PROTOTYPES
        {
            let what =
                format!("shape {number} is declared where shape {} should be", prototypes.len());
            let most = GrainShape::MOST_PROTOTYPES;
            let mend = format!("declare shapes 0, 1, ... in their order, at most {most}");
            return Err(Fault::whole(what, mend));
        }
        let shape = Shape::of_name(name).map_err(|error| {
            Fault::whole(error.to_string(), "use a file that this version of Snowgrain can read")
        })?;
        prototypes.push(shape);
    }
    Ok(prototypes)
}
