//! PLY, text or binary of either byte order.
//!
//! Vertices are the instances of the element `vertex`, with `x`, `y`, `z`. Faces are the lists
//! `vertex_indices` (or `vertex_index`) of `face`, and the strips of `tristrips`. An `edge`
//! references its `vertex1` and `vertex2`. A file is one object. Everything else is skipped.
//!
//! # Reference
//! G. Turk, "The PLY Polygon File Format" (1994). The crate `ply-rs-bw`, with which the tests
//! compare, takes some hundred bytes per vertex, and reads `float` in text as `f32` only.

mod body;
mod header;

use super::fault::{Fault, LineFault, counted};
use super::mesh::{Polygons, Positions, SourceMesh};
use body::{Body, Layout};
use header::{Element, Encoding, Header, Scalar};

/// Number of vertices allowed in any file. Above it, each must take [`VERTEX_BYTES`] of the file.
const FREE_VERTICES: u64 = 1 << 20;

/// Minimum bytes of a vertex: three shorts, or three digits with separators. It takes 45 of memory.
const VERTEX_BYTES: usize = 6;

/// Strip corners allowed in any file. Beyond, each takes [`STRIP_BYTES_A_CORNER`] of the file.
const FREE_STRIP_CORNERS: usize = 1 << 22;

/// Minimum bytes of a strip corner. A corner becomes a triangle of 16 bytes, so corners of one byte
/// would take far more memory than the file. Such corners can address only 256 vertices.
const STRIP_BYTES_A_CORNER: usize = 4;

/// `is_double` selects `f64` for the positions of a text file. The error has its line in a header
/// or text body, or its element in a binary body.
pub fn read(bytes: &[u8], is_double: bool) -> Result<SourceMesh, LineFault> {
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(LineFault::of_file("the file is empty; expected a PLY file: export it again"));
    }
    let header = header::read(bytes)?;
    let mut vertex_elements = header.elements.iter().filter(|element| element.name == "vertex");
    let Some(vertex) = vertex_elements.next() else {
        return Err(LineFault::of_file("the header has no `element vertex`, but a hull requires points"));
    };
    if vertex_elements.next().is_some() {
        // The indices of a face would be ambiguous.
        return Err(LineFault::of_file("the header declares `element vertex` twice; export the file again"));
    }
    if vertex.count == 0 {
        return Err(LineFault::of_file(
            "the file has no vertices, but a hull requires at least one point: check that the export finished",
        ));
    }
    if vertex.count > u64::from(u32::MAX - 1) {
        return Err(Fault::TooManyVertices.of_file());
    }
    if vertex.count > FREE_VERTICES.max((bytes.len() / VERTEX_BYTES) as u64) {
        return Err(LineFault::of_file(format!(
            "the header claims {} vertices, and each takes less than {VERTEX_BYTES} bytes of the file: it was cut off, or has 8-bit coordinates; write them as floats",
            vertex.count
        )));
    }
    let vertex_count = vertex.count as u32;
    let strip_corner_limit = (bytes.len() / STRIP_BYTES_A_CORNER).max(FREE_STRIP_CORNERS);
    let mut body = Body::new(&header, bytes, Layout::Lines);
    let mut mesh = read_body(&mut body, &header, vertex_count, strip_corner_limit, is_double);
    if mesh.is_err() && (body.has_short_line() || body.has_surplus()) {
        // If instances share lines, there are too few lines. If they continue, a line is too short.
        let mut words = Body::new(&header, bytes, Layout::Words);
        let read = read_body(&mut words, &header, vertex_count, strip_corner_limit, is_double);
        if read.is_ok() || body.has_short_line() {
            (mesh, body) = (read, words);
        }
    }
    let mut mesh = mesh?;
    mesh.notes.extend(body.note());
    mesh.notes.extend(header.note);
    Ok(mesh)
}

fn read_body(
    body: &mut Body,
    header: &Header,
    vertex_count: u32,
    strip_corner_limit: usize,
    is_double: bool,
) -> Result<SourceMesh, LineFault> {
    let mut mesh = SourceMesh::new(Positions::Single(Vec::new()), Polygons::default());
    for element in &header.elements {
        body.check_room(element)?;
        match element.name.as_str() {
            "vertex" => mesh.positions = read_vertices(body, header, element, is_double)?,
            "face" => read_faces(body, element, vertex_count, &mut mesh.faces, None)?,
            "tristrips" => read_faces(body, element, vertex_count, &mut mesh.faces, Some(strip_corner_limit))?,
            "edge" => read_edges(body, element, vertex_count, &mut mesh.loose)?,
            _ => body.skip(element)?,
        }
    }
    Ok(mesh)
}

#[expect(clippy::indexing_slicing, reason = "indices that `find` returned or `enumerate` counts, and three axes")]
fn read_vertices(body: &mut Body, header: &Header, element: &Element, is_double: bool) -> Result<Positions, LineFault> {
    let mut axes = [0; 3];
    for (axis, name) in axes.iter_mut().zip(["x", "y", "z"]) {
        *axis = element.find(&[name]).filter(|&place| element.properties[place].length.is_none()).ok_or_else(|| {
            LineFault::of_file(format!("`element vertex` has no number `{name}`, but a hull requires x, y and z"))
        })?;
    }
    let is_text = header.encoding == Encoding::Text;
    let is_double =
        axes.iter().any(|&axis| matches!(element.properties[axis].scalar, Scalar::F64 | Scalar::I32 | Scalar::U32))
            || is_text && is_double;
    let count = element.count as usize;
    let (mut singles, mut doubles) = (Vec::new(), Vec::new());
    if is_double {
        doubles.reserve_exact(count)
    } else {
        singles.reserve_exact(count)
    }
    for vertex in 0..element.count {
        body.begin_instance();
        let mut position = [0.0; 3];
        for (place, property) in element.properties.iter().enumerate() {
            match (property.length, axes.iter().position(|&axis| axis == place)) {
                (Some(length), _) => body.skip_list(length, property.scalar, element, vertex)?,
                (None, Some(axis)) => position[axis] = body.number(property.scalar, is_double, element, vertex)?,
                (None, None) => body.skip_number(property.scalar, element, vertex)?,
            }
        }
        body.end_instance();
        if let Some(wrong) = position.iter().find(|x| !x.is_finite()) {
            return Err(body.fault(format!(
                "vertex {vertex} has the coordinate {wrong}, but a hull requires finite points: repair the mesh in its editor"
            )));
        }
        if is_double {
            doubles.push(position);
        } else {
            // The value is an f32 or a short integer, so this is exact.
            singles.push(position.map(|x| x as f32));
        }
    }
    Ok(if is_double { Positions::Double(doubles) } else { Positions::Single(singles) })
}

/// Polygons, or with a limit on corners triangle strips, in which -1 starts a new strip.
fn read_faces(
    body: &mut Body,
    element: &Element,
    vertex_count: u32,
    faces: &mut Polygons,
    strip_corner_limit: Option<usize>,
) -> Result<(), LineFault> {
    let Some(indices) = element
        .find(&["vertex_indices", "vertex_index"])
        .filter(|&place| element.properties.get(place).is_some_and(|p| p.length.is_some() && p.scalar.is_integer()))
    else {
        return body.skip(element);
    };
    let are_strips = strip_corner_limit.is_some();
    let mut strip_corners = 0;
    let mut strip: Vec<u32> = Vec::new();
    for instance in 0..element.count {
        body.begin_instance();
        for (place, property) in element.properties.iter().enumerate() {
            let Some(length) = property.length else {
                body.skip_number(property.scalar, element, instance)?;
                continue;
            };
            if place != indices {
                body.skip_list(length, property.scalar, element, instance)?;
                continue;
            }
            let corner_count = body.length(length, property.scalar, element, instance)?;
            strip_corners += corner_count as usize;
            if strip_corner_limit.is_some_and(|limit| strip_corners > limit) {
                return Err(LineFault::of_file(format!(
                    "the strips have more than {} corners, the limit for a file of this size: write triangles instead",
                    strip_corner_limit.unwrap_or_default()
                )));
            }
            strip.clear();
            for _ in 0..corner_count {
                let index = body.integer(property.scalar, element, instance)?;
                if are_strips && index == -1 {
                    push_strip(faces, &strip);
                    strip.clear();
                    continue;
                }
                let vertex = in_range(body, index, vertex_count, element, instance)?;
                if are_strips { strip.push(vertex) } else { faces.corners.push(vertex) }
            }
            if are_strips {
                push_strip(faces, &strip);
            } else {
                faces.end();
            }
        }
        body.end_instance();
        if faces.corners.len() > u32::MAX as usize {
            return Err(Fault::TooManyReferences.of_file());
        }
    }
    Ok(())
}

/// Adds the triangles of a strip. Every second one has reversed winding.
fn push_strip(faces: &mut Polygons, strip: &[u32]) {
    for (index, corners) in strip.windows(3).enumerate() {
        if let &[a, b, c] = corners {
            faces.push(&if index % 2 == 0 { [a, b, c] } else { [b, a, c] });
        }
    }
}

fn read_edges(body: &mut Body, element: &Element, vertex_count: u32, loose: &mut Vec<u32>) -> Result<(), LineFault> {
    if element.properties.is_empty() {
        return Ok(());
    }
    for instance in 0..element.count {
        body.begin_instance();
        for property in &element.properties {
            match (property.length, property.name.as_str()) {
                (Some(length), _) => body.skip_list(length, property.scalar, element, instance)?,
                (None, "vertex1" | "vertex2") if property.scalar.is_integer() => {
                    let index = body.integer(property.scalar, element, instance)?;
                    loose.push(in_range(body, index, vertex_count, element, instance)?);
                }
                (None, _) => body.skip_number(property.scalar, element, instance)?,
            }
        }
        body.end_instance();
    }
    Ok(())
}

fn in_range(body: &Body, index: i64, vertex_count: u32, element: &Element, instance: u64) -> Result<u32, LineFault> {
    u32::try_from(index).ok().filter(|&vertex| vertex < vertex_count).ok_or_else(|| {
        body.fault(format!(
            "{} {instance} has the vertex index {index}, which is out of range (the file has {}): check whether the file was cut off or joined from parts",
            element.name,
            counted(vertex_count, "vertex", "vertices")
        ))
    })
}
