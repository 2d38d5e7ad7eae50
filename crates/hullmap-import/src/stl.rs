//! STL, in text or binary: triangles that each spell out their corners.
//!
//! Vertices are the distinct positions, in the order of their first appearance (the two zeros are one): a corner that
//! six triangles share is one vertex. Objects are the `solid`s of a text; a binary file is one object. Normals,
//! attributes and colours are not read.
//!
//! A file is binary where its length is what its triangle count makes it, whatever it begins with: many binary files
//! begin with `solid`, as a text must.
//!
//! # Reference
//! 3D Systems, "StereoLithography Interface Specification" (1989). The crate `stl_io` takes every file that begins with
//! `solid ` for text, ends at the first `endsolid`, and reads f32 only; it is a second opinion in the tests.

use std::collections::HashMap;
use std::hash::Hash;

use crate::coordinate::parse_coordinate;
use crate::fault::{Fault, LineFault, excerpt};
use crate::limits::Limits;
use crate::mesh::{Mesh, Polygons, Positions};
use crate::tokens::{Tokens, text};

/// Bytes before the triangles of a binary file: a free text, and the number of triangles.
const HEADER: usize = 84;

/// Bytes of a triangle in a binary file: normal, three corners, attribute.
const TRIANGLE: usize = 50;

/// Bytes in which a text must have said `facet` or `endsolid`.
const TEXT_PROBE: usize = 4096;

/// Reads an STL file; `wants_double` keeps the digits of f64 in a text.
///
/// # Errors
/// The first fault, with its line in a text, with the triangle in a binary file.
///
/// # Complexity
/// O(bytes).
pub fn read(bytes: &[u8], wants_double: bool, limits: &Limits) -> Result<Mesh, LineFault> {
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(Fault::format("the file is empty; expected an STL file: export it again").of_file());
    }
    let claimed = bytes.get(HEADER - 4..).and_then(<[u8]>::first_chunk).map(|count| u32::from_le_bytes(*count));
    let expected = claimed.map(|count| HEADER as u64 + u64::from(count) * TRIANGLE as u64);
    if expected != Some(bytes.len() as u64) && is_text(bytes) {
        return if wants_double { read_text::<f64>(bytes, limits) } else { read_text::<f32>(bytes, limits) };
    }
    let Some((count, expected)) = claimed.zip(expected) else {
        return Err(Fault::format(format!(
            "{} bytes are neither an STL text, which begins with `solid`, nor a binary file of at least {HEADER}: export it again",
            bytes.len()
        ))
        .of_file());
    };
    let Some(triangles) = usize::try_from(expected).ok().and_then(|end| bytes.get(HEADER..end)) else {
        return Err(Fault::format(format!(
            "the header claims {count} triangles, {expected} bytes, but the file has {}: it was cut off, or is no STL file; export it again",
            bytes.len()
        ))
        .of_file());
    };
    let mut mesh = read_binary(triangles)?;
    if bytes.len() as u64 > expected {
        mesh.warnings.push(format!(
            "{} bytes behind the {count} triangles that the header announces are not read: were triangles added?",
            bytes.len() as u64 - expected
        ));
    }
    Ok(mesh)
}

/// Whether a file begins as a text does and goes on as one.
fn is_text(bytes: &[u8]) -> bool {
    let start = bytes.trim_ascii_start();
    let start = start.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(start);
    let has = |word: &[u8]| {
        let probe = start.get(..TEXT_PROBE).unwrap_or(start);
        probe.windows(word.len()).any(|window| window.eq_ignore_ascii_case(word))
    };
    let is_solid = start.first_chunk().is_some_and(|word: &[u8; 5]| word.eq_ignore_ascii_case(b"solid"));
    is_solid && (has(b"facet") || has(b"endsolid"))
}

/// A coordinate that vertices can be told apart by.
trait Coordinate: super::coordinate::Coordinate {
    /// Its bits.
    type Bits: Copy + Eq + Hash;
    const ZERO: Self;
    fn bits(self) -> Self::Bits;
    /// The positions of all vertices.
    fn positions(all: Vec<[Self; 3]>) -> Positions;
}

impl Coordinate for f32 {
    type Bits = u32;
    const ZERO: f32 = 0.0;
    fn bits(self) -> u32 {
        // Adding +0 turns -0 into +0 and leaves every other number alone.
        (self + 0.0).to_bits()
    }
    fn positions(all: Vec<[f32; 3]>) -> Positions {
        Positions::Single(all)
    }
}

impl Coordinate for f64 {
    type Bits = u64;
    const ZERO: f64 = 0.0;
    fn bits(self) -> u64 {
        (self + 0.0).to_bits()
    }
    fn positions(all: Vec<[f64; 3]>) -> Positions {
        Positions::Double(all)
    }
}

/// Gives equal positions one number.
struct Welder<T: Coordinate> {
    positions: Vec<[T; 3]>,
    numbers: HashMap<[T::Bits; 3], u32>,
}

impl<T: Coordinate> Welder<T> {
    fn new() -> Self {
        Self { positions: Vec::new(), numbers: HashMap::new() }
    }

    fn number(&mut self, position: [T; 3]) -> Result<u32, Fault> {
        let next = u32::try_from(self.positions.len()).map_err(|_| Fault::TooManyVertices)?;
        let number = *self.numbers.entry(position.map(T::bits)).or_insert(next);
        if number == next {
            self.positions.push(position);
        }
        Ok(number)
    }
}

#[expect(clippy::indexing_slicing, reason = "12 bytes of normal and three corners of 12 are within a triangle's 50")]
fn read_binary(triangles: &[u8]) -> Result<Mesh, LineFault> {
    let mut welder = Welder::<f32>::new();
    let mut faces = Polygons::default();
    let count = triangles.len() / TRIANGLE;
    if count > u32::MAX as usize / 3 {
        return Err(Fault::TooManyReferences.of_file());
    }
    faces.corners.reserve_exact(3 * count);
    faces.ends.reserve_exact(count);
    for (number, triangle) in triangles.chunks_exact(TRIANGLE).enumerate() {
        for corner in 0..3 {
            let at = |axis: usize| {
                let start = 12 + 12 * corner + 4 * axis;
                f32::from_le_bytes([triangle[start], triangle[start + 1], triangle[start + 2], triangle[start + 3]])
            };
            let position = [at(0), at(1), at(2)];
            if let Some(wrong) = position.iter().find(|x| !x.is_finite()) {
                return Err(Fault::format(format!(
                    "corner {corner} of triangle {number} has the coordinate {wrong}; a hull needs finite points: mend the mesh where it was made, or export it as text to see"
                ))
                .of_file());
            }
            faces.corners.push(welder.number(position).map_err(Fault::of_file)?);
        }
        faces.end();
    }
    if welder.positions.is_empty() {
        return Err(no_triangles());
    }
    Ok(Mesh::of(f32::positions(welder.positions), faces))
}

fn no_triangles() -> LineFault {
    Fault::format("no triangle found; a hull needs at least one point: did the export finish?").of_file()
}

fn read_text<T: Coordinate>(bytes: &[u8], limits: &Limits) -> Result<Mesh, LineFault> {
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let mut tokens = Tokens::new(bytes, 1);
    let mut welder = Welder::<T>::new();
    // Positions come at the end; objects begin by faces alone.
    let mut mesh = Mesh::of(Positions::Single(Vec::new()), Polygons::default());
    while let Some(word) = tokens.next() {
        if is(word, "solid") {
            let name = text(tokens.rest_of_line()).trim().to_owned();
            if let ([only], true) = (mesh.objects.as_mut_slice(), mesh.faces.is_empty()) {
                only.name = name;
            } else {
                mesh.begin_object(name, limits.objects);
            }
        } else if is(word, "endsolid") {
            tokens.rest_of_line();
        } else if is(word, "facet") {
            read_facet(&mut tokens, &mut welder, &mut mesh.faces)?;
        } else {
            return Err(unexpected(&tokens, Some(word), "`facet`, `solid` or `endsolid`"));
        }
    }
    if welder.positions.is_empty() {
        return Err(no_triangles());
    }
    // Vertices belong to the objects whose faces they are of, never to one by themselves.
    mesh.positions = T::positions(welder.positions);
    for object in mesh.objects.iter_mut().skip(1) {
        object.first_vertex = mesh.positions.len() as u32;
    }
    Ok(mesh)
}

fn read_facet<T: Coordinate>(
    tokens: &mut Tokens,
    welder: &mut Welder<T>,
    faces: &mut Polygons,
) -> Result<(), LineFault> {
    expect(tokens, "normal")?;
    // Normals are often zero or NaN, and nothing depends on them.
    for _ in 0..3 {
        if tokens.next().is_none() {
            return Err(unexpected(tokens, None, "the normal's three numbers"));
        }
    }
    expect(tokens, "outer")?;
    expect(tokens, "loop")?;
    let start = faces.corners.len();
    loop {
        let word = tokens.next();
        match word {
            Some(word) if is(word, "vertex") => {}
            Some(word) if is(word, "endloop") => break,
            _ => return Err(unexpected(tokens, word, "`vertex` or `endloop`")),
        }
        let mut position = [T::ZERO; 3];
        for coordinate in &mut position {
            let Some(word) = tokens.next() else {
                return Err(unexpected(tokens, None, "a coordinate"));
            };
            *coordinate = parse_coordinate::<T>(&text(word)).map_err(|fault| fault.at(tokens.line()))?;
        }
        faces.corners.push(welder.number(position).map_err(Fault::of_file)?);
    }
    if faces.corners.len() - start < 3 {
        let found = faces.corners.len() - start;
        return Err(
            Fault::format(format!("a facet has {found} of its 3 vertices; complete or remove it")).at(tokens.line())
        );
    }
    if faces.corners.len() > u32::MAX as usize {
        return Err(Fault::TooManyReferences.of_file());
    }
    faces.end();
    expect(tokens, "endfacet")
}

fn is(word: &[u8], keyword: &str) -> bool {
    word.eq_ignore_ascii_case(keyword.as_bytes())
}

fn expect(tokens: &mut Tokens, keyword: &str) -> Result<(), LineFault> {
    match tokens.next() {
        Some(word) if is(word, keyword) => Ok(()),
        other => Err(unexpected(tokens, other, &format!("`{keyword}`"))),
    }
}

fn unexpected(tokens: &Tokens, found: Option<&[u8]>, expected: &str) -> LineFault {
    let text = match found {
        Some(word) => format!("`{}`, where {expected} is expected: correct the line", excerpt(&text(word))),
        None => format!("the file ends where {expected} is expected: it was cut off; export it again"),
    };
    Fault::format(text).at(tokens.line())
}
