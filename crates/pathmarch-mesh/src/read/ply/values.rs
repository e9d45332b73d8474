//! Values of a PLY file, after the header.

use super::super::error::Mistake;
use super::super::files::shortened;
use super::header::{Element, Format, Property, Scalar};

/// Reader of the values.
pub struct Values<'a> {
    format: Format,
    rest: &'a [u8],
    /// Lines read of a text, after the header.
    lines: usize,
}

/// Values of one element: scalars and lists by property.
#[derive(Default)]
pub struct Record {
    values: Vec<f64>,
    /// Range of each property in the values.
    ranges: Vec<std::ops::Range<usize>>,
}

impl Record {
    /// Value of a property that is not a list.
    pub fn scalar(&self, property: usize) -> f32 {
        self.values[self.ranges[property].start] as f32
    }
    /// Values of a list.
    pub fn list(&self, property: usize) -> &[f64] {
        &self.values[self.ranges[property].clone()]
    }
}

impl<'a> Values<'a> {
    pub fn new(format: Format, bytes: &'a [u8]) -> Self {
        Self { format, rest: bytes, lines: 0 }
    }

    /// Compares a declared number of elements with the bytes that are left.
    pub fn check_count(&self, element: &Element) -> Result<(), Mistake> {
        let least = |property: &Property| match self.format {
            Format::Text => 2,
            _ => property.length.unwrap_or(property.value).size(),
        };
        let size: usize = element.properties.iter().map(least).sum();
        // The last line of a text needs no end.
        if size > 0 && element.count > (self.rest.len() + 1) / size {
            let problem = format!(
                "{} elements \"{}\" are declared, but {} bytes are left",
                element.count,
                shortened(&element.name),
                self.rest.len()
            );
            return Err(Mistake::new("header", problem));
        }
        Ok(())
    }

    /// Skips all of an element.
    pub fn skip(&mut self, element: &Element) -> Result<(), Mistake> {
        let mut record = Record::default();
        if element.properties.is_empty() {
            return Ok(());
        }
        (0..element.count).try_for_each(|_| self.read(element, &mut record))
    }

    /// Reads one element.
    pub fn read(&mut self, element: &Element, record: &mut Record) -> Result<(), Mistake> {
        record.values.clear();
        record.ranges.clear();
        match self.format {
            Format::Text => self.read_line(element, record),
            _ => element.properties.iter().try_for_each(|property| self.read_property(property, element, record)),
        }
    }

    fn read_property(&mut self, property: &Property, element: &Element, record: &mut Record) -> Result<(), Mistake> {
        let name = || format!("property {} of an element \"{}\"", property.name, element.name);
        let ended = || Mistake::new(name(), "the file ends too early");
        let count = match property.length {
            None => 1,
            Some(length) => {
                let value = self.number(length).ok_or_else(ended)?;
                // As every value has a byte or more, a longer list cannot be there.
                Some(value).filter(|value| *value >= 0.0 && *value <= self.rest.len() as f64).ok_or_else(ended)?
                    as usize
            }
        };
        let start = record.values.len();
        for _ in 0..count {
            record.values.push(self.number(property.value).ok_or_else(ended)?);
        }
        record.ranges.push(start..record.values.len());
        Ok(())
    }

    fn number(&mut self, scalar: Scalar) -> Option<f64> {
        let (bytes, rest) = self.rest.split_at_checked(scalar.size())?;
        self.rest = rest;
        let mut little = [0; 8];
        little[..bytes.len()].copy_from_slice(bytes);
        if self.format == Format::BigEndian {
            little[..bytes.len()].reverse();
        }
        let [a, b, c, d, ..] = little;
        Some(match scalar {
            Scalar::I8 => f64::from(a as i8),
            Scalar::U8 => f64::from(a),
            Scalar::I16 => f64::from(i16::from_le_bytes([a, b])),
            Scalar::U16 => f64::from(u16::from_le_bytes([a, b])),
            Scalar::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Scalar::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Scalar::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Scalar::F64 => f64::from_le_bytes(little),
        })
    }

    /// Reads an element from the next line that is not empty.
    fn read_line(&mut self, element: &Element, record: &mut Record) -> Result<(), Mistake> {
        let line = loop {
            if self.rest.is_empty() {
                return Err(Mistake::new(
                    format!("element \"{}\"", shortened(&element.name)),
                    "the file ends too early",
                ));
            }
            let end = self.rest.iter().position(|&byte| byte == b'\n').unwrap_or(self.rest.len());
            let line = &self.rest[..end];
            self.rest = &self.rest[(end + 1).min(self.rest.len())..];
            self.lines += 1;
            if !line.trim_ascii().is_empty() {
                break line;
            }
        };
        let place = || format!("line {} after the header", self.lines);
        let text = String::from_utf8_lossy(line);
        let mut words = text.split_whitespace();
        let mut number = |property: &Property| {
            let missing = || Mistake::new(place(), format!("property {} is missing", shortened(&property.name)));
            let word = words.next().ok_or_else(missing)?;
            let no_number = || Mistake::new(place(), format!("\"{}\" is not a number", shortened(word)));
            word.parse::<f64>().map_err(|_| no_number())
        };
        for property in &element.properties {
            let start = record.values.len();
            let count = if property.is_list() { number(property)? as usize } else { 1 };
            for _ in 0..count {
                record.values.push(number(property)?);
            }
            record.ranges.push(start..record.values.len());
        }
        Ok(())
    }
}
