//! The rows of a PLY file.

use super::{Element, Encoding, Header, Scalar, Shape};
use crate::error::{Fault, Place};
use std::io::BufRead;

const MEND: &str = "export the file again as PLY 1.0";

/// One row: a number for every single property, the items of the lists. Integers of up to 32 bits
/// are exact as `f64`.
#[derive(Clone, Debug, Default)]
pub(crate) struct Row {
    /// By index of the property; 0 for lists.
    pub(crate) numbers: Vec<f64>,
    /// By index of the property; empty for single numbers.
    pub(crate) lists: Vec<Vec<f64>>,
}

/// Reads rows one after the other.
pub(crate) struct Body<R> {
    reader: R,
    encoding: Encoding,
    /// Bytes of the file that were not read yet.
    remaining: u64,
    /// Lines read, of a text file.
    line: u64,
    text: Vec<u8>,
}

impl<R: BufRead> Body<R> {
    /// The rows after `header`, at whose end `reader` stands.
    pub(crate) fn new(reader: R, header: &Header, file_length: u64) -> Self {
        Self {
            reader,
            encoding: header.encoding,
            remaining: file_length.saturating_sub(header.bytes),
            line: header.lines,
            text: Vec::new(),
        }
    }

    /// Where the row read last stands: its line in a text file, `otherwise` in a binary one.
    pub(crate) fn place(&self, otherwise: Place) -> Place {
        match self.encoding {
            Encoding::Ascii => Place::Line(self.line),
            Encoding::LittleEndian | Encoding::BigEndian => otherwise,
        }
    }

    /// Reads over all rows of an element.
    pub(crate) fn skip(&mut self, element: &Element) -> Result<(), Fault> {
        if element.properties.is_empty() {
            return Ok(());
        }
        let mut row = Row::default();
        (0..element.count).try_for_each(|_| self.read(element, &mut row))
    }

    /// Reads the next row, which is one of `element`.
    pub(crate) fn read(&mut self, element: &Element, row: &mut Row) -> Result<(), Fault> {
        row.numbers.clear();
        row.numbers.resize(element.properties.len(), 0.0);
        row.lists.resize_with(element.properties.len(), Vec::new);
        row.lists.iter_mut().for_each(Vec::clear);
        match self.encoding {
            Encoding::Ascii => self.read_text(element, row),
            Encoding::LittleEndian | Encoding::BigEndian => self.read_binary(element, row),
        }
    }

    fn read_binary(&mut self, element: &Element, row: &mut Row) -> Result<(), Fault> {
        for (index, property) in element.properties.iter().enumerate() {
            match property.shape {
                Shape::Single(scalar) => row.numbers[index] = self.number(scalar)?,
                Shape::List { count, item } => {
                    let count = list_length(self.number(count)?, Place::Whole)?;
                    if count.saturating_mul(item.bytes() as u64) > self.remaining {
                        return Err(Fault::truncated());
                    }
                    for _ in 0..count {
                        let number = self.number(item)?;
                        row.lists[index].push(number);
                    }
                }
            }
        }
        Ok(())
    }

    fn number(&mut self, scalar: Scalar) -> Result<f64, Fault> {
        let little = self.encoding == Encoding::LittleEndian;
        Ok(match scalar {
            Scalar::I8 => f64::from(i8::from_le_bytes(self.bytes(little)?)),
            Scalar::U8 => f64::from(u8::from_le_bytes(self.bytes(little)?)),
            Scalar::I16 => f64::from(i16::from_le_bytes(self.bytes(little)?)),
            Scalar::U16 => f64::from(u16::from_le_bytes(self.bytes(little)?)),
            Scalar::I32 => f64::from(i32::from_le_bytes(self.bytes(little)?)),
            Scalar::U32 => f64::from(u32::from_le_bytes(self.bytes(little)?)),
            Scalar::F32 => f64::from(f32::from_le_bytes(self.bytes(little)?)),
            Scalar::F64 => f64::from_le_bytes(self.bytes(little)?),
        })
    }

    /// The next `N` bytes, least significant first.
    fn bytes<const N: usize>(&mut self, little: bool) -> Result<[u8; N], Fault> {
        let mut bytes = [0; N];
        self.reader.read_exact(&mut bytes)?;
        self.remaining = self.remaining.saturating_sub(N as u64);
        if !little {
            bytes.reverse();
        }
        Ok(bytes)
    }

    fn read_text(&mut self, element: &Element, row: &mut Row) -> Result<(), Fault> {
        loop {
            self.text.clear();
            let read = self.reader.read_until(b'\n', &mut self.text)?;
            self.line += 1;
            if read == 0 {
                return Err(Fault::truncated());
            }
            if !self.text.iter().all(u8::is_ascii_whitespace) {
                break;
            }
        }
        let here = Place::Line(self.line);
        let mut words = self.text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        for (index, property) in element.properties.iter().enumerate() {
            match property.shape {
                Shape::Single(scalar) => {
                    row.numbers[index] = text_number(words.next(), scalar, here)?;
                }
                Shape::List { count, item } => {
                    let count = list_length(text_number(words.next(), count, here)?, here)?;
                    for _ in 0..count {
                        row.lists[index].push(text_number(words.next(), item, here)?);
                    }
                }
            }
        }
        match words.next() {
            None => Ok(()),
            Some(_) => Err(Fault::new(here, "the row has more numbers than declared", MEND)),
        }
    }
}

fn list_length(number: f64, here: Place) -> Result<u64, Fault> {
    if number < 0.0 {
        return Err(Fault::new(here, format!("a list has a length of {number}"), MEND));
    }
    Ok(number as u64)
}

fn text_number(word: Option<&[u8]>, scalar: Scalar, here: Place) -> Result<f64, Fault> {
    let word = word.ok_or_else(|| Fault::new(here, "the row has too few numbers", MEND))?;
    let number: Option<f64> = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
    let fits = |x: &f64| !scalar.is_integer() || x.fract() == 0.0;
    number.filter(fits).ok_or_else(|| {
        let shown: String = String::from_utf8_lossy(word).chars().take(40).collect();
        let kind = if scalar.is_integer() { "an integer" } else { "a number" };
        Fault::new(here, format!("{shown:?} is not {kind}"), MEND)
    })
}
