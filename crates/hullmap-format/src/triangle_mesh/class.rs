//! Classes of the edges and vertices of a triangle mesh.
//!
//! Two triangles meet in a ridge (convex), in a valley (concave), or in one plane (flat). Only at
//! ridges and borders can a contact normal lie between the normals of the faces.

use std::fmt;

/// Sine of the angle up to which an edge is flat, and contacts take a normal as a face's.
pub const FLAT_SINE: f64 = 1e-3;

/// Class of an edge of a triangle.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EdgeClass {
    /// No other triangle has the edge.
    Border = 0,
    /// The neighbour continues in the same plane, to within a sine of 1e-3.
    Flat = 1,
    /// A ridge: the neighbour falls behind the plane of the triangle.
    Convex = 2,
    /// A valley: the neighbour rises before the plane of the triangle.
    Concave = 3,
    /// More than two triangles have the edge.
    NonManifold = 4,
    /// The neighbour's front is on the other side: both triangles have the edge in the same
    /// direction.
    Reversed = 5,
}

impl EdgeClass {
    /// All classes, in order of their codes.
    pub const ALL: [Self; 6] =
        [Self::Border, Self::Flat, Self::Convex, Self::Concave, Self::NonManifold, Self::Reversed];

    /// Name of the class.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Border => "border",
            Self::Flat => "flat",
            Self::Convex => "convex",
            Self::Concave => "concave",
            Self::NonManifold => "non-manifold",
            Self::Reversed => "reversed",
        }
    }

    /// The edges of each class, each once, in the order of [`Self::ALL`], in O(n log n).
    /// `triangles` are corners, and the classes of the edges from each to the next.
    pub fn group(triangles: impl IntoIterator<Item = ([u32; 3], [Self; 3])>) -> Vec<Vec<[u32; 2]>> {
        let mut groups = vec![Vec::new(); Self::ALL.len()];
        for ([a, b, c], classes) in triangles {
            for ([from, to], class) in [[a, b], [b, c], [c, a]].into_iter().zip(classes) {
                // There is a group for each code.
                if let Some(group) = groups.get_mut(usize::from(class.code())) {
                    group.push([from.min(to), from.max(to)]);
                }
            }
        }
        for edges in &mut groups {
            edges.sort_unstable();
            edges.dedup();
        }
        groups
    }

    /// Four bits of [`TriangleMesh::edge_classes`](super::archive::TriangleMesh::edge_classes).
    pub const fn code(self) -> u16 {
        match self {
            Self::Border => 0,
            Self::Flat => 1,
            Self::Convex => 2,
            Self::Concave => 3,
            Self::NonManifold => 4,
            Self::Reversed => 5,
        }
    }

    /// The class with this code.
    pub fn from_code(code: u16) -> Option<Self> {
        Self::ALL.get(usize::from(code)).copied()
    }

    /// Class of the edge `edge` in the classes of a triangle.
    pub fn unpack(classes: u16, edge: usize) -> Option<Self> {
        if edge < 3 { Self::from_code(classes >> (4 * edge) & 15) } else { None }
    }

    /// Whether [`TriangleMesh::neighbours`](super::archive::TriangleMesh::neighbours) names a
    /// triangle on the other side.
    pub const fn has_neighbour(self) -> bool {
        !matches!(self, Self::Border | Self::NonManifold)
    }

    /// Class of a triangle's first edge, if the neighbour's third corner is `opposite` and both
    /// have the same side in front. Beside a triangle without area, it is flat.
    pub fn between([a, b, c]: [[f64; 3]; 3], opposite: [f64; 3]) -> Self {
        let (edge, to_c, to_d) = (minus(b, a), minus(c, a), minus(opposite, a));
        let (own, other) = (cross(edge, to_c), cross(to_d, edge));
        // Their cross product is along the edge, and its length is the sine times both lengths.
        let turn = dot(cross(other, own), edge);
        let sine = turn / (dot(own, own).sqrt() * dot(other, other).sqrt() * dot(edge, edge).sqrt());
        let is_folded = dot(own, other) < 0.0;
        // NaN, of triangles without area, counts as flat.
        if sine > FLAT_SINE || is_folded && sine >= 0.0 {
            Self::Concave
        } else if sine < -FLAT_SINE || is_folded {
            Self::Convex
        } else {
            Self::Flat
        }
    }
}

impl fmt::Display for EdgeClass {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// Class of a vertex, by the edges at it.
///
/// # Examples
/// ```
/// use hullmap_format::triangle_mesh::class::{EdgeClass, VertexClass};
///
/// let of = |edges: &[EdgeClass]| VertexClass::from_edges(edges.iter().copied());
/// assert_eq!(of(&[EdgeClass::Convex, EdgeClass::Flat]), VertexClass::Convex);
/// assert_eq!(of(&[EdgeClass::Convex, EdgeClass::Concave]), VertexClass::Saddle);
/// assert_eq!(of(&[EdgeClass::Convex, EdgeClass::Border]), VertexClass::Border);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum VertexClass {
    /// All its edges are flat.
    Flat,
    /// Its edges are ridges, or flat: a contact normal may be any between the faces' normals.
    Convex,
    /// Its edges are valleys, or flat.
    Concave,
    /// It has ridges and valleys.
    Saddle,
    /// It is on the border.
    Border,
    /// More than two triangles have one of its edges, or two have it in the same direction.
    Irregular,
}

impl VertexClass {
    /// All classes, in order of their codes.
    pub const ALL: [Self; 6] = [Self::Flat, Self::Convex, Self::Concave, Self::Saddle, Self::Border, Self::Irregular];

    /// Name of the class.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Flat => "flat",
            Self::Convex => "convex",
            Self::Concave => "concave",
            Self::Saddle => "saddle",
            Self::Border => "border",
            Self::Irregular => "irregular",
        }
    }

    /// Code of the class.
    pub const fn code(self) -> u8 {
        match self {
            Self::Flat => 0,
            Self::Convex => 1,
            Self::Concave => 2,
            Self::Saddle => 3,
            Self::Border => 4,
            Self::Irregular => 5,
        }
    }

    /// The class with this code.
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.get(usize::from(code)).copied()
    }

    /// Class of a vertex with edges of these classes.
    pub fn from_edges(edges: impl IntoIterator<Item = EdgeClass>) -> Self {
        edges.into_iter().fold(Self::Flat, Self::with)
    }

    /// Class of a vertex of this class with another edge.
    pub fn with(self, edge: EdgeClass) -> Self {
        match (self, edge) {
            (Self::Irregular, _) | (_, EdgeClass::NonManifold | EdgeClass::Reversed) => Self::Irregular,
            (Self::Border, _) | (_, EdgeClass::Border) => Self::Border,
            (_, EdgeClass::Flat) => self,
            (Self::Flat | Self::Convex, EdgeClass::Convex) => Self::Convex,
            (Self::Flat | Self::Concave, EdgeClass::Concave) => Self::Concave,
            (Self::Saddle, _) | (Self::Convex, EdgeClass::Concave) | (Self::Concave, EdgeClass::Convex) => Self::Saddle,
        }
    }
}

impl fmt::Display for VertexClass {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    let ([ax, ay, az], [bx, by, bz]) = (a, b);
    [ax - bx, ay - by, az - bz]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    let ([ax, ay, az], [bx, by, bz]) = (a, b);
    ax * bx + ay * by + az * bz
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    let ([ax, ay, az], [bx, by, bz]) = (a, b);
    [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_match_their_positions() {
        for (at, class) in EdgeClass::ALL.into_iter().enumerate() {
            assert_eq!((usize::from(class.code()), EdgeClass::from_code(at as u16)), (at, Some(class)));
            assert_eq!(EdgeClass::unpack(class.code() << 8, 2), Some(class));
        }
        for (at, class) in VertexClass::ALL.into_iter().enumerate() {
            assert_eq!((usize::from(class.code()), VertexClass::from_code(at as u8)), (at, Some(class)));
        }
        assert_eq!((EdgeClass::from_code(6), VertexClass::from_code(6), EdgeClass::unpack(0, 3)), (None, None, None));
    }

    /// The neighbour turns about the edge by a full turn. The class has the sign of its height.
    #[test]
    fn the_class_is_that_of_the_angle() {
        let corners = [[0.5, 0.0, 0.0], [1.5, 0.0, 0.0], [0.7, 2.0, 0.0]];
        for step in 1..360 {
            let angle = f64::from(step).to_radians();
            // Flat at 180 degrees, where the neighbour is opposite the triangle.
            let opposite = [0.2, 3.0 * angle.cos(), 3.0 * angle.sin()];
            let expected = match step {
                180 => EdgeClass::Flat,
                1..180 => EdgeClass::Concave,
                _ => EdgeClass::Convex,
            };
            assert_eq!(EdgeClass::between(corners, opposite), expected, "{step} degrees");
        }
    }
}
