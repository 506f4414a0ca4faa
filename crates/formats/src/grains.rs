//! Grain files: PLY with `double x y z` and `float radius` in metres; of grains that are not all spheres, also
//! `uchar shape`, whose number names a comment, and an orientation.
//!
//! Comments hold the unit, the up axis, and the origin and quantum of the lattice that the grains
//! are stored on, so that reading gives back the same [`QuantisedGrain`]s in the same order. Files
//! of other programs need only the four properties, of any type; they are rounded to a lattice
//! made for their largest radius.

mod shapes;

use crate::error::{Fault, FormatsError, Place, abridged, room};
use crate::mesh::{coordinates, single_property};
use crate::ply::{Body, Element, Header, Row};
use crate::{atomic, input};
use shapes::ShapeLayout;
use snowgrain_geometry::{Quantisation, QuantisedGrain};
use snowgrain_grains::{FieldShapes, GrainField};
use snowgrain_math::DVec3;
use std::io::{self, BufRead, Seek, SeekFrom, Write};
use std::path::Path;

/// Writes a grain file: 28 bytes a grain after a header, or 35 where grains have shapes.
///
/// # Errors
/// [`FormatsError::BadOutput`] where a grain would not come back as it is (a radius of 0, or an
/// origin so far away that doubles cannot tell its quanta apart); what [`atomic::write`] refuses.
pub fn write_grains(path: &Path, field: &GrainField) -> Result<(), FormatsError> {
    if let Some(index) = field.quantised().position(|grain| !survives(field, grain)) {
        return Err(FormatsError::BadOutput {
            path: path.to_path_buf(),
            what: format!("grain {index} (from 0) cannot be stored exactly"),
            mend: "give it a radius, and the scene an origin that is nearer".into(),
        });
    }
    atomic::write(path, |writer| write(writer, field))
}

/// Reads a grain file of Snowgrain or of another program.
///
/// # Errors
/// A missing or unreadable file; content that is not grains; a radius that is zero, negative or not
/// a number, or a position out of reach, with the vertex.
pub fn read_grains(path: &Path) -> Result<GrainField, FormatsError> {
    let (reader, length) = input::open(path)?;
    read(reader, length).map_err(|fault| fault.of(path))
}

/// Whether a grain comes back from a file as it is.
fn survives(field: &GrainField, grain: QuantisedGrain) -> bool {
    let metres = field.quantisation.grain(grain);
    let back = field.quantisation.round(metres.center, f64::from(metres.radius as f32));
    grain.radius > 0 && back == Ok(grain)
}

fn write(writer: &mut impl Write, field: &GrainField) -> io::Result<()> {
    let lattice = &field.quantisation;
    let [x, y, z] = lattice.origin().to_array();
    write!(
        writer,
        "ply\n\
         format binary_little_endian 1.0\n\
         comment snowgrain grains 1\n\
         comment unit metre\n\
         comment up y\n\
         comment quantum {:e}\n\
         comment origin {x:e} {y:e} {z:e}\n\
         ",
        lattice.quantum(),
    )?;
    if let Some(FieldShapes { prototypes, .. }) = field.shapes() {
        shapes::write_prototypes(writer, prototypes)?;
    }
    write!(
        writer,
        "element vertex {}\n\
         property double x\n\
         property double y\n\
         property double z\n\
         property float radius\n",
        field.len()
    )?;
    if field.shapes().is_some() {
        writer.write_all(shapes::PROPERTIES.as_bytes())?;
    }
    writer.write_all(b"end_header\n")?;
    for (index, grain) in field.iter().enumerate() {
        let mut row = [0; 28];
        for (bytes, x) in row.chunks_exact_mut(8).zip(grain.center.to_array()) {
            bytes.copy_from_slice(&x.to_le_bytes());
        }
        row[24..].copy_from_slice(&(grain.radius as f32).to_le_bytes());
        writer.write_all(&row)?;
        if let Some(FieldShapes { of_grains, .. }) = field.shapes() {
            writer.write_all(&shapes::row(of_grains[index]))?;
        }
    }
    Ok(())
}

fn read(mut reader: impl BufRead + Seek, length: u64) -> Result<GrainField, Fault> {
    let header = Header::read(&mut reader, length)?;
    let layout = Layout::of(&header)?;
    let quantisation = match lattice(&header.comments)? {
        (origin, Some(quantum)) => Quantisation::from_parts(origin, quantum),
        (origin, None) => {
            let mut largest = 0.0f64;
            layout.each_grain(&mut reader, &header, length, |_, _, radius, row| {
                let reach = layout.shapes.as_ref().map_or(1.0, |shapes| shapes.reach(row));
                largest = largest.max(radius * reach);
                Ok(())
            })?;
            if largest == 0.0 {
                return Err(Fault::whole("the file holds no grains", "give one with grains"));
            }
            reader.seek(SeekFrom::Start(header.bytes))?;
            Quantisation::for_grains(origin, largest)
        }
    };
    let count = usize::try_from(layout.vertex.count)
        .map_err(|_| Fault::TooLarge(format!("a list of {} grains", layout.vertex.count)))?;
    let mut grains = room(count, "grains")?;
    let mut of_grains = room(if layout.shapes.is_some() { count } else { 0 }, "shapes of grains")?;
    layout.each_grain(&mut reader, &header, length, |place, center, radius, row| {
        if let Some(shapes) = &layout.shapes {
            of_grains.push(shapes.of_row(place, row)?);
        }
        grains.push(rounded(&quantisation, place, center, radius)?);
        Ok(())
    })?;
    let field = GrainField::new(quantisation, grains);
    Ok(match layout.shapes {
        Some(shapes) => field.with_shapes(shapes.with(of_grains)),
        None => field,
    })
}

fn rounded(
    quantisation: &Quantisation,
    place: Place,
    center: DVec3,
    radius: f64,
) -> Result<QuantisedGrain, Fault> {
    quantisation.round(center, radius).map_err(|error| {
        Fault::new(place, error.to_string(), "mend the grain or remove it from the file")
    })
}

/// Where the numbers of a grain stand in its row.
struct Layout<'a> {
    vertex: &'a Element,
    axes: [usize; 3],
    radius: usize,
    shapes: Option<ShapeLayout>,
}

impl<'a> Layout<'a> {
    fn of(header: &'a Header) -> Result<Self, Fault> {
        let vertex = header.element("vertex").ok_or_else(|| {
            Fault::whole("the file has no element \"vertex\"", "give a file of grains")
        })?;
        let radius = single_property(vertex, "radius")?;
        if header.element("face").is_some_and(|faces| faces.count > 0) {
            let mend = "name it as the \"file\" of an [[object]] table, or remove the faces";
            return Err(Fault::whole("this file has faces: it is a mesh, not grains", mend));
        }
        let shapes = ShapeLayout::of(vertex, &header.comments)?;
        Ok(Self { vertex, axes: coordinates(vertex)?, radius, shapes })
    }

    /// Calls `visit` with place, centre, radius and row of every grain in the order of the file; both
    /// are finite and the radius is positive.
    fn each_grain(
        &self,
        reader: &mut impl BufRead,
        header: &Header,
        length: u64,
        mut visit: impl FnMut(Place, DVec3, f64, &Row) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        let mut body = Body::new(reader, header, length);
        let before = header.elements.iter().take_while(|element| element.name != "vertex");
        before.into_iter().try_for_each(|element| body.skip(element))?;
        let mut row = Row::default();
        for index in 0..self.vertex.count {
            body.read(self.vertex, &mut row)?;
            let place = body.place(Place::Vertex(index));
            let center = DVec3::from_array(self.axes.map(|axis| row.numbers[axis]));
            let radius = row.numbers[self.radius];
            if !(radius > 0.0 && radius.is_finite()) {
                let what = format!("a radius of {radius} (vertex {index} from 0)");
                let mend = "give every grain a positive radius in metres";
                return Err(Fault::new(place, what, mend));
            }
            if !center.is_finite() {
                let what = format!("a position that is not finite (vertex {index} from 0)");
                return Err(Fault::new(place, what, "give every grain a position in metres"));
            }
            visit(place, center, radius, &row)?;
        }
        Ok(())
    }
}

/// Origin and quantum of the lattice that the comments declare, in metres.
fn lattice(comments: &[String]) -> Result<(DVec3, Option<f64>), Fault> {
    let (mut origin, mut quantum) = (DVec3::ZERO, None);
    for comment in comments {
        let words: Vec<&str> = comment.split_whitespace().collect();
        match words[..] {
            ["unit", "m" | "metre" | "metres" | "meter" | "meters"] | ["up", "y" | "Y"] => {}
            ["unit", unit] => {
                let what = format!("lengths are in {:?}", abridged(unit));
                return Err(Fault::whole(what, "give grains in metres: \"comment unit metre\""));
            }
            ["up", axis] => {
                let what = format!("the axis that points up is {:?}", abridged(axis));
                return Err(Fault::whole(what, "turn the grains so that y points up"));
            }
            ["snowgrain", "grains", version] if version != "1" => {
                let what = format!("version {:?} of grain files is not known", abridged(version));
                return Err(Fault::whole(what, "use a newer Snowgrain"));
            }
            ["origin", x, y, z] => {
                origin = DVec3::new(metres(x)?, metres(y)?, metres(z)?);
            }
            ["quantum", text] => quantum = Some(quantum_of(metres(text)?)?),
            _ => {}
        }
    }
    Ok((origin, quantum))
}

fn metres(text: &str) -> Result<f64, Fault> {
    text.parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(|| {
        let what = format!("{:?} in a comment is not a finite number", abridged(text));
        Fault::whole(what, "mend the comment or remove it")
    })
}

/// The quantum, if it is one of which all multiples are exact (at most 20 significant bits).
fn quantum_of(quantum: f64) -> Result<f64, Fault> {
    let exact = quantum.to_bits() & ((1 << 33) - 1) == 0;
    if quantum.is_normal() && quantum > 0.0 && exact {
        return Ok(quantum);
    }
    let what = format!("a quantum of {quantum} m is none that Snowgrain makes");
    Err(Fault::whole(what, "remove the comment \"quantum\": one is then chosen"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use snowgrain_geometry::{GrainShape, Shape, ShapeKind};
    use std::io::Cursor;

    fn read_bytes(bytes: &[u8]) -> Result<GrainField, FormatsError> {
        read(Cursor::new(bytes), bytes.len() as u64).map_err(|f| f.of(Path::new("grains.ply")))
    }

    fn written(field: &GrainField) -> Vec<u8> {
        let mut bytes = Vec::new();
        write(&mut bytes, field).unwrap();
        bytes
    }

    fn any_field() -> impl Strategy<Value = GrainField> {
        let reach = Quantisation::MAX_COORDINATE;
        let center = prop::array::uniform3(-reach..=reach);
        let grain = (center, 1..=Quantisation::MAX_RADIUS_QUANTA)
            .prop_map(|(center, radius)| QuantisedGrain { center, radius });
        let origin = prop::array::uniform3(-10.0..10.0f64);
        (prop::collection::vec(grain, 0..40), origin, 1e-5..1e-1f64, any::<bool>()).prop_map(
            |(grains, origin, radius, is_shaped)| {
                let origin = DVec3::from_array(origin);
                let field = GrainField::new(Quantisation::for_grains(origin, radius), grains);
                if is_shaped { shaped(field) } else { field }
            },
        )
    }

    /// The field with a shape for each grain.
    fn shaped(field: GrainField) -> GrainField {
        let plate = ShapeKind::HexagonalPrism { aspect: 0.15, rounding: 0.1 };
        let random = ShapeKind::RandomPolyhedron { faces: 9, seed: 1 << 60, rounding: 0.0 };
        let prototypes: Vec<Shape> = [ShapeKind::Sphere, plate, random]
            .iter()
            .map(|&kind| Shape::new(kind).unwrap())
            .collect();
        let cut = Shape::of_faces(prototypes[2].parts()[0].faces.clone()).unwrap();
        let prototypes: Vec<Shape> = prototypes.into_iter().chain([cut]).collect();
        let shape = |(index, grain): (usize, QuantisedGrain)| {
            let [x, y, z] = grain.center.map(f64::from);
            GrainShape::new(index % 4, [x, y, z, f64::from(grain.radius)])
        };
        let of_grains = field.quantised().enumerate().map(shape).collect();
        field.with_shapes(FieldShapes { prototypes: prototypes.into(), of_grains })
    }

    #[test]
    fn shapes_that_are_none_are_refused_with_their_place() {
        let grain = QuantisedGrain { center: [1, 2, 3], radius: 4 };
        let field = GrainField::new(Quantisation::for_grains(DVec3::ZERO, 1.0), vec![grain]);
        let good = written(&shaped(field));
        let with = |from: &str, to: &str| {
            let at = good.windows(from.len()).position(|w| w == from.as_bytes()).unwrap();
            let bytes = [&good[..at], to.as_bytes(), &good[at + from.len()..]].concat();
            read_bytes(&bytes).unwrap_err().to_string()
        };
        let unknown = with("comment shape 1 hexagonal-prism", "comment shape 1 hexagonal-disc");
        assert!(unknown.contains("hexagonal-disc"), "{unknown}");
        let gap = with("comment shape 1", "comment shape 7");
        assert!(gap.contains("shape 7"), "{gap}");
        let missing = with("property ushort orientation_1\n", "property ushort orientation_9\n");
        assert!(missing.contains("orientation_1"), "{missing}");
        let mut bytes = good.clone();
        let at = bytes.len() - 7;
        bytes[at] = 200;
        let number = read_bytes(&bytes).unwrap_err().to_string();
        assert!(number.contains("shape 200"), "{number}");
    }

    fn text(vertices: &str, count: usize) -> Vec<u8> {
        format!(
            "ply\nformat ascii 1.0\nelement vertex {count}\nproperty float x\nproperty float y\n\
             property float z\nproperty float radius\nend_header\n{vertices}"
        )
        .into_bytes()
    }

    proptest! {
        #[test]
        fn grains_come_back_as_they_were(field in any_field()) {
            prop_assert!(field.quantised().all(|grain| survives(&field, grain)));
            prop_assert_eq!(read_bytes(&written(&field)).unwrap(), field);
        }

        #[test]
        fn damaged_files_are_read_or_refused(
            field in any_field(),
            changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
            cut in any::<prop::sample::Index>(),
        ) {
            let mut bytes = written(&field);
            for (at, value) in changes {
                let at = at.index(bytes.len());
                bytes[at] = value;
            }
            let _ = read_bytes(&bytes);
            let _ = read_bytes(&bytes[..cut.index(bytes.len())]);
        }

        #[test]
        fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
            let _ = read_bytes(&bytes);
            let _ = read_bytes(&[&b"ply\n"[..], &bytes].concat());
        }
    }

    #[test]
    fn grains_of_other_programs_are_rounded_to_a_lattice_of_their_largest_radius() {
        let field = read_bytes(&text("0.1 0.2 0.3 0.0005\n-1 0 0 0.00025\n", 2)).unwrap();
        assert_eq!(field.quantisation, Quantisation::for_grains(DVec3::ZERO, 0.0005));
        let quantum = field.quantisation.quantum();
        let (first, second) = (field.iter().next().unwrap(), field.iter().nth(1).unwrap());
        assert!((first.center - DVec3::new(0.1, 0.2, 0.3)).abs().max_element() <= quantum);
        assert!((second.radius - 0.00025).abs() <= quantum);
    }

    #[test]
    fn radii_that_are_none_are_refused_with_their_place() {
        for radius in ["0", "-0.001", "nan", "inf"] {
            let error = read_bytes(&text(&format!("0 0 0 0.001\n0 0 0 {radius}\n"), 2));
            let error = error.unwrap_err();
            assert_eq!(error.exit_code(), 65);
            assert!(error.to_string().starts_with("grains.ply, line 10: a radius of"), "{error}");
        }
        let tiny = read_bytes(&text("0 0 0 0.001\n0 0 0 1e-9\n", 2)).unwrap_err().to_string();
        assert!(tiny.contains("cannot be stored"), "{tiny}");
    }

    #[test]
    fn four_billion_grains_in_a_file_of_200_bytes_are_refused_by_arithmetic() {
        let mut bytes = text("", 4_294_967_295);
        bytes.resize(200, b' ');
        let error = read_bytes(&bytes).unwrap_err();
        assert_eq!(error.exit_code(), 65);
        assert!(error.to_string().contains("claims 4294967295 rows"), "{error}");
    }

    #[test]
    fn other_units_axes_and_versions_are_refused() {
        for comment in ["unit mm", "up z", "snowgrain grains 2", "quantum 0.1", "quantum nan"] {
            let field = String::from_utf8(text("0 0 0 1\n", 1)).unwrap();
            let field = field.replace("element", &format!("comment {comment}\nelement"));
            assert!(read_bytes(field.as_bytes()).is_err(), "{comment}");
        }
    }
}
