//! PLY, in text or binary of either byte order.
//!
//! Vertices are those of the element `vertex`, by `x`, `y`, `z`; faces are the lists `vertex_indices` (or
//! `vertex_index`) of `face`, and the strips of `tristrips`; an `edge` references its `vertex1` and `vertex2`. A file is
//! one object. Everything else is passed over.
//!
//! # Reference
//! G. Turk, "The PLY Polygon File Format" (1994). The crate `ply-rs-bw` keeps a map of names for each element, some
//! hundred bytes a vertex, and f32 only for `float` in texts; it is a second opinion in the tests.

mod body;
mod header;

use super::fault::{Fault, LineFault};
use super::mesh::{Mesh, Polygons, Positions};
use body::Body;
use header::{Element, Encoding, Header, Scalar};

/// Vertices that any file may have; beyond, each must have taken [`VERTEX_BYTES`].
const FREE_VERTICES: u64 = 1 << 20;

/// Bytes of a vertex: three shorts, or three digits with their blanks. It becomes 45 bytes in memory.
const VERTEX_BYTES: usize = 6;

/// Corners of strips that any file may have; beyond, each must have taken [`STRIP_BYTES_A_CORNER`].
const FREE_STRIP_CORNERS: usize = 1 << 22;

/// Bytes of a strip's corner. A corner becomes a triangle of 16 bytes, so that corners of one byte, of which 256 vertices
/// are all that they can name, would take far more memory than the file.
const STRIP_BYTES_A_CORNER: usize = 4;

/// Reads a PLY file; `wants_double` keeps the digits of f64 in a text.
///
/// # Errors
/// The first fault: with its line in header and text, with the element in a binary body.
///
/// # Complexity
/// O(bytes).
pub fn read(bytes: &[u8], wants_double: bool) -> Result<Mesh, LineFault> {
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(Fault::format("the file is empty; expected a PLY file: export it again").of_file());
    }
    let header = header::read(bytes)?;
    let mut vertex_elements = header.elements.iter().filter(|element| element.name == "vertex");
    let Some(vertex) = vertex_elements.next() else {
        return Err(Fault::format("the header has no `element vertex`; a hull needs points").of_file());
    };
    if vertex_elements.next().is_some() {
        // Of which would a face's numbers be?
        return Err(Fault::format("the header has `element vertex` twice; export the file again").of_file());
    }
    if vertex.count == 0 {
        return Err(Fault::format("the file has no vertices; a hull needs at least one point: did the export finish?")
            .of_file());
    }
    if vertex.count > u64::from(u32::MAX - 1) {
        return Err(Fault::TooManyVertices.of_file());
    }
    if vertex.count > FREE_VERTICES.max((bytes.len() / VERTEX_BYTES) as u64) {
        return Err(Fault::format(format!(
            "{} vertices of less than {VERTEX_BYTES} bytes each, or the file was cut off: write coordinates as floats",
            vertex.count
        ))
        .of_file());
    }
    let vertex_count = vertex.count as u32;
    let most_strip_corners = (bytes.len() / STRIP_BYTES_A_CORNER).max(FREE_STRIP_CORNERS);
    let mut body = Body::new(&header, bytes);
    let mut mesh = Mesh::of(Positions::Single(Vec::new()), Polygons::default());
    for element in &header.elements {
        body.check_room(element)?;
        match element.name.as_str() {
            "vertex" => mesh.positions = read_vertices(&mut body, &header, element, wants_double)?,
            "face" => read_faces(&mut body, element, vertex_count, &mut mesh.faces, None)?,
            "tristrips" => read_faces(&mut body, element, vertex_count, &mut mesh.faces, Some(most_strip_corners))?,
            "edge" => read_edges(&mut body, element, vertex_count, &mut mesh.loose)?,
            _ => body.skip(element)?,
        }
    }
    Ok(mesh)
}

#[expect(
    clippy::indexing_slicing,
    reason = "places that `find` has found, or that were counted; of axes there are three"
)]
fn read_vertices(
    body: &mut Body,
    header: &Header,
    element: &Element,
    wants_double: bool,
) -> Result<Positions, LineFault> {
    let mut axes = [0; 3];
    for (axis, name) in axes.iter_mut().zip(["x", "y", "z"]) {
        *axis = element.find(&[name]).filter(|&place| element.properties[place].length.is_none()).ok_or_else(|| {
            Fault::format(format!("`element vertex` has no number `{name}`; a hull needs x, y and z")).of_file()
        })?;
    }
    let is_text = header.encoding == Encoding::Text;
    let is_double =
        axes.iter().any(|&axis| matches!(element.properties[axis].scalar, Scalar::F64 | Scalar::I32 | Scalar::U32))
            || is_text && wants_double;
    let count = element.count as usize;
    let (mut singles, mut doubles) = (Vec::new(), Vec::new());
    if is_double {
        doubles.reserve_exact(count)
    } else {
        singles.reserve_exact(count)
    }
    for vertex in 0..element.count {
        let mut position = [0.0; 3];
        for (place, property) in element.properties.iter().enumerate() {
            match (property.length, axes.iter().position(|&axis| axis == place)) {
                (Some(length), _) => body.skip_list(length, property.scalar, element, vertex)?,
                (None, Some(axis)) => position[axis] = body.number(property.scalar, is_double, element, vertex)?,
                (None, None) => body.skip_number(property.scalar, element, vertex)?,
            }
        }
        if let Some(wrong) = position.iter().find(|x| !x.is_finite()) {
            return Err(body.fault(format!(
                "vertex {vertex} has the coordinate {wrong}; a hull needs finite points: mend the mesh where it was made"
            )));
        }
        if is_double {
            doubles.push(position);
        } else {
            // Exactly an f32, or a short whole number.
            singles.push(position.map(|x| x as f32));
        }
    }
    Ok(if is_double { Positions::Double(doubles) } else { Positions::Single(singles) })
}

/// Reads lists of vertex numbers as polygons, or, with their most corners given, as strips of triangles in which -1
/// begins a new strip.
fn read_faces(
    body: &mut Body,
    element: &Element,
    vertex_count: u32,
    faces: &mut Polygons,
    most_strip_corners: Option<usize>,
) -> Result<(), LineFault> {
    let Some(indices) = element
        .find(&["vertex_indices", "vertex_index"])
        .filter(|&place| element.properties.get(place).is_some_and(|p| p.length.is_some() && p.scalar.is_whole()))
    else {
        return body.skip(element);
    };
    let are_strips = most_strip_corners.is_some();
    let mut strip_corners = 0;
    let mut strip: Vec<u32> = Vec::new();
    for number in 0..element.count {
        for (place, property) in element.properties.iter().enumerate() {
            let Some(length) = property.length else {
                body.skip_number(property.scalar, element, number)?;
                continue;
            };
            if place != indices {
                body.skip_list(length, property.scalar, element, number)?;
                continue;
            }
            let count = body.length(length, property.scalar, element, number)?;
            strip_corners += count as usize;
            if most_strip_corners.is_some_and(|most| strip_corners > most) {
                return Err(Fault::format(format!(
                    "strips of {strip_corners} corners, where a file of this size can have {}: write triangles instead",
                    most_strip_corners.unwrap_or_default()
                ))
                .of_file());
            }
            strip.clear();
            for _ in 0..count {
                let index = body.whole(property.scalar, element, number)?;
                if are_strips && index == -1 {
                    push_strip(faces, &strip);
                    strip.clear();
                    continue;
                }
                let vertex = in_range(body, index, vertex_count, element, number)?;
                if are_strips { strip.push(vertex) } else { faces.corners.push(vertex) }
            }
            if are_strips {
                push_strip(faces, &strip);
            } else {
                faces.end();
            }
        }
        if faces.corners.len() > u32::MAX as usize {
            return Err(Fault::TooManyReferences.of_file());
        }
    }
    Ok(())
}

/// Every other triangle of a strip is wound the other way.
fn push_strip(faces: &mut Polygons, strip: &[u32]) {
    for (number, &[a, b, c]) in strip.array_windows().enumerate() {
        faces.push(&if number % 2 == 0 { [a, b, c] } else { [b, a, c] });
    }
}

fn read_edges(body: &mut Body, element: &Element, vertex_count: u32, loose: &mut Vec<u32>) -> Result<(), LineFault> {
    if element.properties.is_empty() {
        return Ok(());
    }
    for number in 0..element.count {
        for property in &element.properties {
            match (property.length, property.name.as_str()) {
                (Some(length), _) => body.skip_list(length, property.scalar, element, number)?,
                (None, "vertex1" | "vertex2") if property.scalar.is_whole() => {
                    let index = body.whole(property.scalar, element, number)?;
                    loose.push(in_range(body, index, vertex_count, element, number)?);
                }
                (None, _) => body.skip_number(property.scalar, element, number)?,
            }
        }
    }
    Ok(())
}

fn in_range(body: &Body, index: i64, count: u32, element: &Element, number: u64) -> Result<u32, LineFault> {
    u32::try_from(index).ok().filter(|&vertex| vertex < count).ok_or_else(|| {
        body.fault(format!(
            "{} {number} names vertex {index}, but vertices are numbered from 0 to {}: was the file cut off or put together from parts?",
            element.name,
            count - 1
        ))
    })
}
