//! Positions and primitives of a COLLADA geometry.
//!
//! They are appended to the mesh as they are read, once for each instance: separate lists would
//! take more memory than a file may.

use std::collections::HashMap;

use glam::{DAffine3, DVec3};
use roxmltree::Node;

use super::xml::{child, fault_at, local, number};
use crate::fault::{Fault, LineFault, excerpt};
use crate::mesh::Polygons;

/// Maximum number of indices of a corner. Files have up to ten.
const MAX_INPUTS: usize = 64;

#[derive(Debug)]
pub struct Target<'m> {
    pub positions: &'m mut Vec<[f64; 3]>,
    pub faces: &'m mut Polygons,
    pub loose: &'m mut Vec<u32>,
    /// From the geometry's frame to the scene's.
    pub placed: DAffine3,
    pub has_holes: bool,
}

struct Layout {
    /// Place of the index of a position.
    offset: usize,
    stride: usize,
    /// Index of the geometry's first position, and number of its positions.
    first: u32,
    count: u32,
}

/// The node of a geometry with its vertices and primitives, and the source of its positions; `None`
/// without vertices. Fails if the vertices have no positions.
pub fn positions_of<'a, 'input>(
    geometry: Node<'a, 'input>,
    ids: &HashMap<&str, Node<'a, 'input>>,
) -> Result<Option<(Node<'a, 'input>, Node<'a, 'input>)>, LineFault> {
    let Some(mesh) = child(geometry, "mesh").or_else(|| child(geometry, "convex_mesh")) else { return Ok(None) };
    let Some(vertices) = child(mesh, "vertices") else { return Ok(None) };
    let input = vertices.children().find(|input| input.attribute("semantic") == Some("POSITION"));
    let input = input.ok_or_else(|| fault_at(vertices, "the vertices have no positions: export the file again"))?;
    Ok(Some((mesh, source(input, ids)?)))
}

impl Target<'_> {
    /// Appends the positions of a source and the primitives of a mesh.
    pub fn append(&mut self, mesh: Node, source: Node) -> Result<(), LineFault> {
        let first = self.positions.len();
        self.add_positions(source)?;
        let too_many = || Fault::TooManyVertices.of_file();
        let end = u32::try_from(self.positions.len()).ok().filter(|end| *end < u32::MAX).ok_or_else(too_many)?;
        let (first, count) = (first as u32, end - first as u32);
        for primitive in mesh.children().filter(Node::is_element) {
            self.add(primitive, first, count)?;
        }
        Ok(())
    }

    fn add_positions(&mut self, source: Node) -> Result<(), LineFault> {
        let array = child(source, "float_array");
        let array =
            array.ok_or_else(|| fault_at(source, "the positions have no `float_array`: export the file again"))?;
        let accessor = child(source, "technique_common").and_then(|common| child(common, "accessor"));
        let stated = |name: &str| accessor.and_then(|accessor| accessor.attribute(name)?.trim().parse::<usize>().ok());
        let (offset, stride) = (stated("offset").unwrap_or(0), stated("stride").unwrap_or(3));
        let places = accessor.map_or([0, 1, 2], places);
        if stride <= places.into_iter().max().unwrap_or_default() {
            return Err(fault_at(source, "the stride of the positions is below 3: export the file again"));
        }
        let count = stated("count").unwrap_or(usize::MAX);
        let before = self.positions.len();
        let (mut entry, mut found) = ([0.0; 3], 0_usize);
        let words = array.text().unwrap_or_default().split_ascii_whitespace().skip(offset);
        for (index, word) in words.enumerate() {
            if found == count {
                break;
            }
            let place = index % stride;
            for (axis, own) in entry.iter_mut().zip(places) {
                if own == place {
                    *axis = number(array, word)?;
                }
            }
            if place == stride - 1 {
                let position = self.placed.transform_point3(DVec3::from_array(entry));
                if !position.is_finite() {
                    return Err(fault_at(
                        array,
                        "a transformed position is not finite: check the transforms of its nodes",
                    ));
                }
                self.positions.push(position.to_array());
                found += 1;
            }
        }
        if count != usize::MAX && self.positions.len() - before < count {
            let text = format!(
                "the accessor states {count} positions, but there are {found}: the file was cut off; export it again"
            );
            return Err(fault_at(source, text));
        }
        Ok(())
    }

    fn add(&mut self, primitive: Node, first: u32, count: u32) -> Result<(), LineFault> {
        let kind = primitive.tag_name().name();
        if !["triangles", "polylist", "polygons", "trifans", "tristrips", "lines", "linestrips"].contains(&kind) {
            return Ok(());
        }
        let layout = layout(primitive, first, count)?;
        let counts = child(primitive, "vcount").and_then(|counts| counts.text()).unwrap_or_default();
        let mut counts = counts.split_ascii_whitespace();
        for list in primitive.descendants().filter(|node| node.tag_name().name() == "p") {
            self.has_holes |= list.parent_element().is_some_and(|parent| parent.tag_name().name() == "ph");
            let mut corners = layout.corners(list);
            match kind {
                "triangles" => self.add_faces(primitive, &mut corners, || Some(3))?,
                "polylist" => self.add_faces(primitive, &mut corners, || counts.next()?.parse().ok())?,
                "polygons" => {
                    for corner in corners {
                        self.faces.corners.push(self.checked(corner?)?);
                    }
                    self.faces.end();
                }
                "trifans" | "tristrips" => self.add_triangles(&mut corners, kind == "trifans")?,
                _ => {
                    for corner in corners {
                        self.loose.push(corner?);
                    }
                }
            }
        }
        Ok(())
    }

    fn checked(&self, corner: u32) -> Result<u32, LineFault> {
        if self.faces.corners.len() >= u32::MAX as usize {
            return Err(Fault::TooManyReferences.of_file());
        }
        Ok(corner)
    }

    /// Faces one after the other; `count` returns the number of corners of the next.
    fn add_faces(
        &mut self,
        primitive: Node,
        corners: &mut impl Iterator<Item = Result<u32, LineFault>>,
        mut count: impl FnMut() -> Option<usize>,
    ) -> Result<(), LineFault> {
        let mut next = corners.next().transpose()?;
        while let Some(first) = next {
            let count = count().filter(|count| *count > 0);
            let start = self.faces.corners.len();
            self.faces.corners.push(self.checked(first)?);
            for corner in corners.by_ref().take(count.unwrap_or(1) - 1) {
                self.faces.corners.push(self.checked(corner?)?);
            }
            if count != Some(self.faces.corners.len() - start) {
                let text = "the list of indices does not end with a face: the file was cut off; export it again";
                return Err(fault_at(primitive, text));
            }
            self.turn(start);
            self.faces.end();
            next = corners.next().transpose()?;
        }
        Ok(())
    }

    /// Triangles of a fan, or of a strip, in which every second one is turned.
    fn add_triangles(
        &mut self,
        corners: &mut impl Iterator<Item = Result<u32, LineFault>>,
        is_fan: bool,
    ) -> Result<(), LineFault> {
        let (Some(mut a), Some(mut b)) = (corners.next().transpose()?, corners.next().transpose()?) else {
            return Ok(());
        };
        for (index, corner) in corners.enumerate() {
            let c = self.checked(corner?)?;
            let start = self.faces.corners.len();
            let is_turned = !is_fan && index % 2 == 1;
            self.faces.corners.extend(if is_turned { [b, a, c] } else { [a, b, c] });
            self.turn(start);
            self.faces.end();
            if !is_fan {
                a = b;
            }
            b = c;
        }
        Ok(())
    }

    /// Reverses the last face, which starts at `start`, if the transform mirrors.
    fn turn(&mut self, start: usize) {
        if self.placed.matrix3.determinant() < 0.0
            && let Some(face) = self.faces.corners.get_mut(start..)
        {
            face.reverse();
        }
    }
}

impl Layout {
    fn corners<'n>(&self, list: Node<'n, '_>) -> impl Iterator<Item = Result<u32, LineFault>> + use<'n, '_> {
        let (first, count) = (self.first, self.count);
        let words = list.text().unwrap_or_default().split_ascii_whitespace().skip(self.offset).step_by(self.stride);
        words.map(move |word| {
            let index = word.parse().ok().filter(|index: &u32| *index < count);
            index.map(|index| first + index).ok_or_else(|| {
                let word = excerpt(word);
                let text = format!(
                    "vertex index `{word}` is out of range (the geometry has {count} vertices): export the file again"
                );
                fault_at(list, text)
            })
        })
    }
}

fn layout(primitive: Node, first: u32, count: u32) -> Result<Layout, LineFault> {
    let (mut offset, mut stride) = (None, 0);
    for input in primitive.children().filter(|node| node.tag_name().name() == "input") {
        let own: usize = input.attribute("offset").unwrap_or("0").trim().parse().unwrap_or(MAX_INPUTS);
        if own >= MAX_INPUTS {
            return Err(fault_at(
                input,
                format!("the offset is not a number below {MAX_INPUTS}: export the file again"),
            ));
        }
        stride = stride.max(own + 1);
        if input.attribute("semantic") == Some("VERTEX") {
            offset = Some(own);
        }
    }
    let offset =
        offset.ok_or_else(|| fault_at(primitive, "the primitives have no input `VERTEX`: export the file again"))?;
    Ok(Layout { offset, stride, first, count })
}

fn source<'a, 'input>(
    input: Node<'a, 'input>,
    ids: &HashMap<&str, Node<'a, 'input>>,
) -> Result<Node<'a, 'input>, LineFault> {
    let id = local(input, "source")?;
    let found = ids.get(id).copied();
    found.ok_or_else(|| fault_at(input, format!("there is no source `{}`: export the file again", excerpt(id))))
}

/// Places of x, y and z in an entry; parameters without a name are skipped.
fn places(accessor: Node) -> [usize; 3] {
    let params = accessor.children().filter(|node| node.tag_name().name() == "param").enumerate();
    let mut named = params.filter(|(_, param)| param.attribute("name").is_some()).map(|(place, _)| place);
    match (named.next(), named.next(), named.next()) {
        (Some(x), Some(y), Some(z)) => [x, y, z],
        _ => [0, 1, 2],
    }
}
