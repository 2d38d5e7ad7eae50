//! STL, text or binary: triangles that each spell out their corners.
//!
//! Vertices are the distinct positions in order of first appearance, where -0 equals +0: a corner
//! that six triangles share is one vertex. Objects are the `solid`s of a text file; a binary file
//! is one object. Normals, attributes and colours are not read.
//!
//! A file is binary if its length agrees with its triangle count, whatever its first bytes are:
//! many binary files start with `solid`, as text files must.
//!
//! # Reference
//! 3D Systems, "StereoLithography Interface Specification" (1989). The crate `stl_io` treats every
//! file that starts with `solid ` as text, stops at the first `endsolid`, and reads `f32` only. The
//! tests compare with it.

use std::collections::HashMap;
use std::hash::Hash;

use crate::coordinate::{Coordinate, parse_coordinate};
use crate::fault::{Fault, LineFault, counted, excerpt};
use crate::limits::Limits;
use crate::mesh::{Polygons, Positions, SourceMesh};
use crate::tokens::{Tokens, text};

/// Bytes before the triangles of a binary file: a comment and the triangle count.
const HEADER: usize = 84;

/// Bytes of a triangle in a binary file: normal, three corners, attribute.
const TRIANGLE: usize = 50;

/// Number of bytes within which a text file must contain `facet` or `endsolid`.
const TEXT_PROBE: usize = 4096;

/// `is_double` selects `f64` for the positions of a text file. The error has its line in a text
/// file, or its triangle in a binary file.
pub fn read(bytes: &[u8], is_double: bool, limits: &Limits) -> Result<SourceMesh, LineFault> {
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(LineFault::of_file("the file is empty; expected an STL file: export it again"));
    }
    let claimed = triangle_count(bytes);
    let expected = claimed.map(binary_length);
    if !has_binary_length(bytes) && is_text(bytes) {
        return if is_double { read_text::<f64>(bytes, limits) } else { read_text::<f32>(bytes, limits) };
    }
    let Some((triangle_count, expected)) = claimed.zip(expected) else {
        return Err(LineFault::of_file(format!(
            "the file has {}; expected STL text, which starts with `solid`, or a binary file of at least {HEADER} bytes: export it again",
            counted(bytes.len(), "byte", "bytes")
        )));
    };
    let Some(triangles) = usize::try_from(expected).ok().and_then(|end| bytes.get(HEADER..end)) else {
        return Err(LineFault::of_file(format!(
            "the header claims {} ({expected} bytes), but the file has {} bytes: it was cut off or is not STL; export it again",
            counted(triangle_count, "triangle", "triangles"),
            bytes.len()
        )));
    };
    let mut mesh = read_binary(triangles)?;
    if bytes.len() as u64 > expected {
        mesh.warnings.push(format!(
            "{} not read, since the header states {}; check whether triangles are missing",
            counted(
                bytes.len() as u64 - expected,
                "byte at the end of the file is",
                "bytes at the end of the file are"
            ),
            counted(triangle_count, "triangle", "triangles")
        ));
    }
    Ok(mesh)
}

fn triangle_count(bytes: &[u8]) -> Option<u32> {
    bytes.get(HEADER - 4..).and_then(<[u8]>::first_chunk).map(|count| u32::from_le_bytes(*count))
}

fn binary_length(triangle_count: u32) -> u64 {
    HEADER as u64 + u64::from(triangle_count) * TRIANGLE as u64
}

pub fn has_binary_length(bytes: &[u8]) -> bool {
    triangle_count(bytes).map(binary_length) == Some(bytes.len() as u64)
}

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

trait MergeKey: Coordinate {
    type Bits: Copy + Eq + Hash;
    /// Bits of the coordinate; both zeros have the same.
    fn key(self) -> Self::Bits;
    fn positions(all: Vec<[Self; 3]>) -> Positions;
}

impl MergeKey for f32 {
    type Bits = u32;
    fn key(self) -> u32 {
        // Adding +0 turns -0 into +0 and changes no other number.
        (self + 0.0).to_bits()
    }
    fn positions(all: Vec<[f32; 3]>) -> Positions {
        Positions::Single(all)
    }
}

impl MergeKey for f64 {
    type Bits = u64;
    fn key(self) -> u64 {
        (self + 0.0).to_bits()
    }
    fn positions(all: Vec<[f64; 3]>) -> Positions {
        Positions::Double(all)
    }
}

struct VertexMerger<T: MergeKey> {
    positions: Vec<[T; 3]>,
    indices: HashMap<[T::Bits; 3], u32>,
}

impl<T: MergeKey> VertexMerger<T> {
    fn new() -> Self {
        Self { positions: Vec::new(), indices: HashMap::new() }
    }

    fn index(&mut self, position: [T; 3]) -> Result<u32, Fault> {
        let next = u32::try_from(self.positions.len()).map_err(|_| Fault::TooManyVertices)?;
        let index = *self.indices.entry(position.map(T::key)).or_insert(next);
        if index == next {
            self.positions.push(position);
        }
        Ok(index)
    }
}

#[expect(clippy::indexing_slicing, reason = "12 bytes of normal and three corners of 12 are within a triangle's 50")]
fn read_binary(triangles: &[u8]) -> Result<SourceMesh, LineFault> {
    let mut merger = VertexMerger::<f32>::new();
    let mut faces = Polygons::default();
    let count = triangles.len() / TRIANGLE;
    if count > u32::MAX as usize / 3 {
        return Err(Fault::TooManyReferences.of_file());
    }
    faces.corners.reserve_exact(3 * count);
    faces.ends.reserve_exact(count);
    for (index, triangle) in triangles.chunks_exact(TRIANGLE).enumerate() {
        for corner in 0..3 {
            let at = |axis: usize| {
                let start = 12 + 12 * corner + 4 * axis;
                f32::from_le_bytes([triangle[start], triangle[start + 1], triangle[start + 2], triangle[start + 3]])
            };
            let position = [at(0), at(1), at(2)];
            if let Some(wrong) = position.iter().find(|x| !x.is_finite()) {
                return Err(LineFault::of_file(format!(
                    "corner {corner} of triangle {index} has the coordinate {wrong}, but a hull requires finite points: repair the mesh in its editor"
                )));
            }
            faces.corners.push(merger.index(position).map_err(Fault::of_file)?);
        }
        faces.end();
    }
    if merger.positions.is_empty() {
        return Err(no_triangles());
    }
    Ok(SourceMesh::new(f32::positions(merger.positions), faces))
}

fn no_triangles() -> LineFault {
    LineFault::of_file("no triangles found, but a hull requires at least one point: check that the export finished")
}

fn read_text<T: MergeKey>(bytes: &[u8], limits: &Limits) -> Result<SourceMesh, LineFault> {
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let mut tokens = Tokens::new(bytes, 1);
    let mut merger = VertexMerger::<T>::new();
    // The positions are added at the end. Until then only faces determine where an object starts.
    let mut mesh = SourceMesh::new(Positions::Single(Vec::new()), Polygons::default());
    while let Some(word) = tokens.next() {
        if is(word, "solid") {
            let name = text(tokens.rest_of_line()).trim().to_owned();
            if let ([only], true) = (mesh.objects.as_mut_slice(), mesh.faces.is_empty()) {
                only.name = name;
            } else {
                mesh.begin_object(name, limits.objects);
            }
        } else if ends(&mut tokens, word, "solid") {
            tokens.rest_of_line();
        } else if is(word, "facet") {
            read_facet(&mut tokens, &mut merger, &mut mesh.faces)?;
        } else {
            return Err(unexpected(&tokens, Some(word), "`facet`, `solid` or `endsolid`"));
        }
    }
    if merger.positions.is_empty() {
        return Err(no_triangles());
    }
    // A vertex belongs to the objects whose faces reference it. None is declared in an object.
    mesh.positions = T::positions(merger.positions);
    for object in mesh.objects.iter_mut().skip(1) {
        object.first_vertex = mesh.positions.len() as u32;
    }
    Ok(mesh)
}

fn read_facet<T: MergeKey>(
    tokens: &mut Tokens,
    merger: &mut VertexMerger<T>,
    faces: &mut Polygons,
) -> Result<(), LineFault> {
    expect(tokens, "normal")?;
    // Normals are often zero or NaN, and nothing depends on them.
    for _ in 0..3 {
        if tokens.next().is_none() {
            return Err(unexpected(tokens, None, "one of the three numbers of a normal"));
        }
    }
    expect(tokens, "outer")?;
    expect(tokens, "loop")?;
    let start = faces.corners.len();
    loop {
        let word = tokens.next();
        match word {
            Some(word) if is(word, "vertex") => {}
            Some(word) if ends(tokens, word, "loop") => break,
            _ => return Err(unexpected(tokens, word, "`vertex` or `endloop`")),
        }
        let mut position = [T::ZERO; 3];
        for coordinate in &mut position {
            let Some(word) = tokens.next() else {
                return Err(unexpected(tokens, None, "a coordinate"));
            };
            *coordinate = parse_coordinate::<T>(&text(word)).map_err(|fault| fault.at_line(tokens.line()))?;
        }
        faces.corners.push(merger.index(position).map_err(Fault::of_file)?);
    }
    let found = faces.corners.len() - start;
    if found < 3 {
        let text = format!("a facet has {}; expected 3: complete or remove it", counted(found, "vertex", "vertices"));
        return Err(Fault::format(text).at_line(tokens.line()));
    }
    if faces.corners.len() > u32::MAX as usize {
        return Err(Fault::TooManyReferences.of_file());
    }
    faces.end();
    match tokens.next() {
        Some(word) if ends(tokens, word, "facet") => Ok(()),
        other => Err(unexpected(tokens, other, "`endfacet`")),
    }
}

/// Whether a word ends an element: `endsolid`, or `end solid`, as some programs write.
fn ends(tokens: &mut Tokens, word: &[u8], element: &str) -> bool {
    match word.split_at_checked("end".len()) {
        Some((end, rest)) if is(end, "end") => {
            is(rest, element) || rest.is_empty() && tokens.next().is_some_and(|word| is(word, element))
        }
        _ => false,
    }
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
        Some(word) => format!("found `{}`; expected {expected}: correct the line", excerpt(&text(word))),
        None => format!("the file ends; expected {expected}: it was cut off, so export it again"),
    };
    Fault::format(text).at_line(tokens.line())
}
