//! The header of a PLY file.

use crate::error::{Fault, Place, abridged};
use std::io::{BufRead, Read};

/// Longest header that is read, bytes.
const LONGEST_HEADER: u64 = 1 << 16;
/// Most properties of all elements together.
const MOST_PROPERTIES: usize = 256;

const MEND: &str = "export the file again as PLY 1.0";

/// How rows are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// Types of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes in a binary file.
    pub(crate) fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    pub(crate) fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }
}

/// One number or many.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shape {
    Single(Scalar),
    List { count: Scalar, item: Scalar },
}

/// A property of the rows of an element.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Property {
    pub(crate) name: String,
    pub(crate) shape: Shape,
}

/// A table of rows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Element {
    pub(crate) name: String,
    pub(crate) count: u64,
    pub(crate) properties: Vec<Property>,
}

impl Element {
    /// Index of the property of that name.
    pub(crate) fn property(&self, name: &str) -> Option<usize> {
        self.properties.iter().position(|property| property.name == name)
    }

    /// Fewest bytes that a row can take.
    fn least_row_bytes(&self, encoding: Encoding) -> u64 {
        let least = |property: &Property| match (encoding, property.shape) {
            (Encoding::Ascii, _) => 2, // a digit and a separator
            (_, Shape::Single(scalar)) => scalar.bytes() as u64,
            (_, Shape::List { count, .. }) => count.bytes() as u64,
        };
        self.properties.iter().map(least).sum()
    }
}

/// What a PLY file declares.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Header {
    pub(crate) encoding: Encoding,
    pub(crate) comments: Vec<String>,
    pub(crate) elements: Vec<Element>,
    /// Bytes and lines that the header takes.
    pub(crate) bytes: u64,
    pub(crate) lines: u64,
}

impl Header {
    /// The element of that name.
    pub(crate) fn element(&self, name: &str) -> Option<&Element> {
        self.elements.iter().find(|element| element.name == name)
    }

    /// Reads a header and compares its counts with the length of the file in bytes.
    pub(crate) fn read(reader: &mut impl BufRead, file_length: u64) -> Result<Self, Fault> {
        let mut header = Self {
            encoding: Encoding::Ascii,
            comments: Vec::new(),
            elements: Vec::new(),
            bytes: 0,
            lines: 0,
        };
        let mut encoding = None;
        loop {
            let text = header.next_line(reader)?;
            let here = Place::Line(header.lines);
            let words: Vec<&str> = text.split_whitespace().collect();
            if header.lines == 1 {
                if words != ["ply"] {
                    let what = "this is not a PLY file: it does not begin with \"ply\"";
                    return Err(Fault::new(here, what, "name a PLY file"));
                }
                continue;
            }
            match words[..] {
                ["end_header"] => break,
                [] | ["obj_info", ..] => {}
                ["comment", ..] => {
                    header.comments.push(text.trim_start()["comment".len()..].trim().to_owned());
                }
                ["format", name, "1.0"] => encoding = Some(encoding_from_name(name, here)?),
                ["element", name, count] => {
                    let count = count.parse().map_err(|_| {
                        Fault::new(here, format!("{count:?} is not a number of rows"), MEND)
                    })?;
                    header.elements.push(Element {
                        name: name.to_owned(),
                        count,
                        properties: Vec::new(),
                    });
                }
                ["property", ref declaration @ ..] => header.add_property(declaration, here)?,
                _ => {
                    let what = format!("{:?} does not belong in a PLY header", abridged(&text));
                    return Err(Fault::new(here, what, MEND));
                }
            }
        }
        header.encoding =
            encoding.ok_or_else(|| Fault::whole("the PLY header has no \"format\" line", MEND))?;
        header.check_length(file_length)?;
        Ok(header)
    }

    fn next_line(&mut self, reader: &mut impl BufRead) -> Result<String, Fault> {
        let mut line = Vec::new();
        let left = LONGEST_HEADER - self.bytes;
        self.bytes += reader.by_ref().take(left).read_until(b'\n', &mut line)? as u64;
        self.lines += 1;
        if line.pop() != Some(b'\n') {
            let what = format!("no \"end_header\" within the first {} bytes", self.bytes);
            return Err(Fault::new(Place::Line(self.lines), what, "name a PLY file"));
        }
        Ok(String::from_utf8_lossy(&line).into_owned())
    }

    fn add_property(&mut self, declaration: &[&str], here: Place) -> Result<(), Fault> {
        let scalar = |name: &str| {
            Scalar::from_name(name).ok_or_else(|| {
                Fault::new(here, format!("{:?} is not a type of PLY", abridged(name)), MEND)
            })
        };
        let (name, shape) = match *declaration {
            ["list", count, item, name] => {
                let (count, item) = (scalar(count)?, scalar(item)?);
                if !count.is_integer() {
                    let what = "the length of a list must be an integer";
                    return Err(Fault::new(here, what, MEND));
                }
                (name, Shape::List { count, item })
            }
            [kind, name] => (name, Shape::Single(scalar(kind)?)),
            _ => return Err(Fault::new(here, "a property needs a type and a name", MEND)),
        };
        let held: usize = self.elements.iter().map(|element| element.properties.len()).sum();
        if held == MOST_PROPERTIES {
            let what = format!("there are more than {MOST_PROPERTIES} properties");
            return Err(Fault::new(here, what, MEND));
        }
        let Some(element) = self.elements.last_mut() else {
            return Err(Fault::new(here, "a property comes before any element", MEND));
        };
        element.properties.push(Property { name: name.to_owned(), shape });
        Ok(())
    }

    /// Refuses counts that the file cannot hold, so that they may be trusted from here on.
    fn check_length(&self, file_length: u64) -> Result<(), Fault> {
        let available = u128::from(file_length.saturating_sub(self.bytes));
        let mut needed = 0;
        for element in &self.elements {
            let row = element.least_row_bytes(self.encoding);
            needed += u128::from(element.count) * u128::from(row);
            // The separator after the last number of a text file may be missing.
            if needed > available + u128::from(self.encoding == Encoding::Ascii) {
                let what = format!(
                    "the header claims {} rows of \"{}\", which need at least {needed} bytes, but \
                     only {available} follow",
                    element.count, element.name
                );
                return Err(Fault::whole(what, "the file is cut off or damaged: make it again"));
            }
        }
        Ok(())
    }
}

fn encoding_from_name(name: &str, here: Place) -> Result<Encoding, Fault> {
    match name {
        "ascii" => Ok(Encoding::Ascii),
        "binary_little_endian" => Ok(Encoding::LittleEndian),
        "binary_big_endian" => Ok(Encoding::BigEndian),
        _ => Err(Fault::new(here, format!("{:?} is not a format of PLY", abridged(name)), MEND)),
    }
}
