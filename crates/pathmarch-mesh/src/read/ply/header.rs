//! Header of a PLY file.

use super::super::error::Mistake;
use super::super::files::shortened;

/// Most elements and properties of a header.
const MAX_PROPERTIES: usize = 1000;

/// Encoding of the values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Text,
    LittleEndian,
    BigEndian,
}

/// Type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scalar {
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
    fn parse(name: &str) -> Option<Self> {
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
    /// Bytes of a value.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// Property of an element.
#[derive(Clone, Debug)]
pub struct Property {
    pub name: String,
    /// Type of the value, or of a list's values.
    pub value: Scalar,
    /// Type of a list's length.
    pub length: Option<Scalar>,
}

impl Property {
    pub fn is_list(&self) -> bool {
        self.length.is_some()
    }
    /// Value that means one in a colour.
    pub fn largest(&self) -> f32 {
        match self.value {
            Scalar::U8 => 255.0,
            Scalar::U16 => 65535.0,
            _ => 1.0,
        }
    }
}

/// Kind of record, and how many there are.
#[derive(Clone, Debug)]
pub struct Element {
    pub name: String,
    pub count: usize,
    pub properties: Vec<Property>,
}

/// Header of a file.
pub struct Header {
    pub format: Format,
    pub elements: Vec<Element>,
    /// Bytes of the header.
    pub length: usize,
}

impl Header {
    pub fn parse(bytes: &[u8]) -> Result<Self, Mistake> {
        let mut header = Self { format: Format::Text, elements: Vec::new(), length: 0 };
        let mut format = None;
        for number in 1_u64.. {
            let place = format!("line {number}");
            let rest = &bytes[header.length..];
            let end = rest.iter().position(|&byte| byte == b'\n');
            let end = end.ok_or_else(|| Mistake::new(&place, "the file ends within the header"))?;
            header.length += end + 1;
            let line = String::from_utf8_lossy(&rest[..end]);
            let words: Vec<&str> = line.split_whitespace().take(6).collect();
            match words.as_slice() {
                ["ply"] if number == 1 => {}
                _ if number == 1 => return Err(Mistake::new(place, "the file does not begin with \"ply\"")),
                ["format", name, _] => format = Some(parse_format(name, &place)?),
                ["comment" | "obj_info", ..] | [] => {}
                ["end_header"] => {
                    let missing = || Mistake::new(place, "the header has no format");
                    header.format = format.ok_or_else(missing)?;
                    return Ok(header);
                }
                words => header.declare(words, &place)?,
            }
        }
        unreachable!("the loop ends with the bytes")
    }

    /// Declaration of an element or a property.
    fn declare(&mut self, words: &[&str], place: &str) -> Result<(), Mistake> {
        let mistake = |problem: &str| Mistake::new(place, format!("{problem}: \"{}\"", shortened(&words.join(" "))));
        let total: usize = self.elements.iter().map(|element| 1 + element.properties.len()).sum();
        if total >= MAX_PROPERTIES {
            return Err(mistake("more than a thousand elements and properties"));
        }
        if let ["element", name, count] = words {
            let count = count.parse().map_err(|_| mistake("not a number of elements"))?;
            self.elements.push(Element { name: name.to_string(), count, properties: Vec::new() });
            return Ok(());
        }
        let scalar = |name: &str| Scalar::parse(name).ok_or_else(|| mistake("unknown type"));
        let property = match words {
            ["property", "list", length, value, name] => {
                let length = scalar(length)?;
                if matches!(length, Scalar::F32 | Scalar::F64) {
                    return Err(mistake("the length of a list must be an integer"));
                }
                Property { name: name.to_string(), value: scalar(value)?, length: Some(length) }
            }
            ["property", value, name] => Property { name: name.to_string(), value: scalar(value)?, length: None },
            _ => return Err(mistake("not a declaration of PLY")),
        };
        let element = self.elements.last_mut().ok_or_else(|| mistake("a property before the first element"))?;
        element.properties.push(property);
        Ok(())
    }
}

fn parse_format(name: &str, place: &str) -> Result<Format, Mistake> {
    match name {
        "ascii" => Ok(Format::Text),
        "binary_little_endian" => Ok(Format::LittleEndian),
        "binary_big_endian" => Ok(Format::BigEndian),
        _ => Err(Mistake::new(place, format!("unknown format \"{}\"", shortened(name)))),
    }
}
