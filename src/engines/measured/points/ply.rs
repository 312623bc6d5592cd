//! Vertices of PLY files (G. Turk, The PLY polygon file format, 1994), ASCII and binary.

use glam::DVec3;
use import::excerpt;

use super::Source;
use crate::MeasuredError;

/// Longest header that is read (bytes).
const LONGEST_HEADER: usize = 1 << 18;

const AGAIN: &str = "export the scan again";
const CUT_OFF: &str = "the file is cut off: export or copy it again";

/// Type of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Type {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Type {
    fn of(word: &[u8]) -> Option<Self> {
        Some(match word {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// A property of an element.
#[derive(Debug, Clone, Copy)]
enum Property {
    Scalar(Type),
    List { count: Type, item: Type },
}

/// An element of the header.
#[derive(Debug)]
struct Element {
    is_vertex: bool,
    count: u64,
    properties: Vec<Property>,
    /// Properties that are x, y and z.
    place: [Option<usize>; 3],
}

/// Encoding of the numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

struct Header {
    encoding: Encoding,
    elements: Vec<Element>,
    /// Bytes and lines of the header.
    length: usize,
    lines: usize,
}

/// Whether a file begins as PLY files do.
pub(super) fn is_like(bytes: &[u8]) -> bool {
    matches!(bytes, [b'p', b'l', b'y', b'\n' | b'\r', ..])
}

/// Reads the vertices. What comes before them is skipped, what comes after is not looked at.
pub(super) fn read(source: &Source) -> Result<Vec<DVec3>, MeasuredError> {
    let header = header(source)?;
    let mut numbers =
        Numbers { source, bytes: source.bytes, at: header.length, line: header.lines, encoding: header.encoding };
    for element in &header.elements {
        if element.is_vertex {
            return vertices(source, element, &mut numbers);
        }
        skip(source, element, &mut numbers)?;
    }
    Err(source.malformed("header".to_owned(), "there is no element vertex", AGAIN))
}

fn header(source: &Source) -> Result<Header, MeasuredError> {
    let head = &source.bytes[..source.bytes.len().min(LONGEST_HEADER)];
    // Lines end as the first one does.
    let end = if head.get(3) == Some(&b'\r') && head.get(4) != Some(&b'\n') { b'\r' } else { b'\n' };
    let (mut at, mut lines) = (0, 0);
    let (mut encoding, mut elements) = (None, Vec::<Element>::new());
    while let Some(length) = head[at..].iter().position(|b| *b == end) {
        let line = head[at..at + length].trim_ascii();
        at += length + 1;
        lines += 1;
        let refuse = |problem: &str| {
            let problem = format!("{problem}: {}", excerpt(line));
            Err(source.malformed(format!("line {lines}"), problem, AGAIN))
        };
        let words: Vec<&[u8]> = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).collect();
        match words.as_slice() {
            [] | [b"ply"] | [b"comment" | b"obj_info", ..] => {}
            [b"format", b"ascii", ..] => encoding = Some(Encoding::Ascii),
            [b"format", b"binary_little_endian", ..] => encoding = Some(Encoding::LittleEndian),
            [b"format", b"binary_big_endian", ..] => encoding = Some(Encoding::BigEndian),
            [b"element", name, count] => {
                let Some(count) = std::str::from_utf8(count).ok().and_then(|text| text.parse().ok()) else {
                    return refuse("the number of an element is not a number");
                };
                let is_vertex = *name == b"vertex";
                elements.push(Element { is_vertex, count, properties: Vec::new(), place: [None; 3] });
            }
            [b"property", rest @ ..] => {
                let property = match rest {
                    [b"list", count, item, name] => {
                        Type::of(count).zip(Type::of(item)).map(|(count, item)| (Property::List { count, item }, *name))
                    }
                    [kind, name] => Type::of(kind).map(|kind| (Property::Scalar(kind), *name)),
                    _ => None,
                };
                let (Some(element), Some((property, name))) = (elements.last_mut(), property) else {
                    return refuse("a property cannot be read");
                };
                let axis = [b"x", b"y", b"z"].iter().position(|axis| axis.as_slice() == name);
                if let (Some(axis), Property::Scalar(_)) = (axis, property) {
                    element.place[axis] = Some(element.properties.len());
                }
                element.properties.push(property);
            }
            [b"end_header"] => {
                let Some(encoding) = encoding else { return refuse("there is no format before the end of the header") };
                return Ok(Header { encoding, elements, length: at, lines });
            }
            _ => return refuse("the header has a line that cannot be read"),
        }
    }
    Err(source.malformed("header".to_owned(), "there is no end_header", CUT_OFF))
}

fn vertices(source: &Source, element: &Element, numbers: &mut Numbers) -> Result<Vec<DVec3>, MeasuredError> {
    let [Some(x), Some(y), Some(z)] = element.place else {
        return Err(source.malformed("header".to_owned(), "the element vertex has no x, y and z", AGAIN));
    };
    source.check_count(element.count)?;
    // No more than the rest of the file can hold: three numbers of a byte each at least.
    let room = (source.bytes.len() - numbers.at) as u64 / 3;
    let mut points = Vec::with_capacity(element.count.min(room) as usize);
    for i in 0..element.count {
        source.tick(i as usize, i as f64 / element.count as f64)?;
        let mut p = DVec3::ZERO;
        for (k, property) in element.properties.iter().enumerate() {
            match property {
                Property::Scalar(kind) if k == x => p.x = numbers.next(*kind)?,
                Property::Scalar(kind) if k == y => p.y = numbers.next(*kind)?,
                Property::Scalar(kind) if k == z => p.z = numbers.next(*kind)?,
                other => numbers.skip(*other)?,
            }
        }
        points.push(source.believed(p, || format!("vertex {}", i + 1))?);
    }
    Ok(points)
}

fn skip(source: &Source, element: &Element, numbers: &mut Numbers) -> Result<(), MeasuredError> {
    // Each row takes at least a byte, so that the end of the file ends this, too.
    if element.properties.is_empty() {
        return Ok(());
    }
    for i in 0..element.count {
        source.tick(i as usize, 0.0)?;
        element.properties.iter().try_for_each(|property| numbers.skip(*property))?;
    }
    Ok(())
}

/// The numbers after the header.
struct Numbers<'a> {
    source: &'a Source<'a>,
    bytes: &'a [u8],
    at: usize,
    line: usize,
    encoding: Encoding,
}

impl<'a> Numbers<'a> {
    fn place(&self) -> String {
        match self.encoding {
            Encoding::Ascii => format!("line {}", self.line + 1),
            _ => format!("byte {}", self.at + 1),
        }
    }

    fn ended(&self) -> MeasuredError {
        self.source.malformed(self.place(), "the file ends before all vertices", CUT_OFF)
    }

    /// The bytes of the next number, or the next word.
    fn take(&mut self, kind: Type) -> Result<&'a [u8], MeasuredError> {
        if self.encoding == Encoding::Ascii {
            return self.word();
        }
        let rest = &self.bytes[self.at..];
        let taken = rest.get(..kind.size()).ok_or_else(|| self.ended())?;
        self.at += taken.len();
        Ok(taken)
    }

    fn word(&mut self) -> Result<&'a [u8], MeasuredError> {
        while let Some(b) = self.bytes.get(self.at).filter(|b| b.is_ascii_whitespace()) {
            self.line += usize::from(*b == b'\n');
            self.at += 1;
        }
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        if length == 0 {
            return Err(self.ended());
        }
        self.at += length;
        Ok(&rest[..length])
    }

    fn next(&mut self, kind: Type) -> Result<f64, MeasuredError> {
        let taken = self.take(kind)?;
        if self.encoding == Encoding::Ascii {
            let number = std::str::from_utf8(taken).ok().and_then(|word| word.parse().ok());
            return number.ok_or_else(|| {
                self.source.malformed(self.place(), format!("{} is not a number", excerpt(taken)), AGAIN)
            });
        }
        // In little-endian order, the rest zero.
        let mut bytes = [0; 8];
        bytes[..taken.len()].copy_from_slice(taken);
        if self.encoding == Encoding::BigEndian {
            bytes[..taken.len()].reverse();
        }
        let [a, b, c, d, ..] = bytes;
        Ok(match kind {
            Type::I8 => f64::from(i8::from_le_bytes([a])),
            Type::U8 => f64::from(a),
            Type::I16 => f64::from(i16::from_le_bytes([a, b])),
            Type::U16 => f64::from(u16::from_le_bytes([a, b])),
            Type::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Type::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Type::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Type::F64 => f64::from_le_bytes(bytes),
        })
    }

    fn skip(&mut self, property: Property) -> Result<(), MeasuredError> {
        match property {
            Property::Scalar(kind) => self.take(kind).map(drop),
            Property::List { count, item } => {
                let place = self.place();
                let length = self.next(count)?;
                if !(length >= 0.0 && length.fract() == 0.0) {
                    let problem = format!("a list has {length} items");
                    return Err(self.source.malformed(place, problem, AGAIN));
                }
                if self.encoding == Encoding::Ascii {
                    return (0..length as u64).try_for_each(|_| self.word().map(drop));
                }
                let wanted = (length as usize).saturating_mul(item.size());
                if wanted > self.bytes.len() - self.at {
                    return Err(self.ended());
                }
                self.at += wanted;
                Ok(())
            }
        }
    }
}
