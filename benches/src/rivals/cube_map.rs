//! The paper's cube map (section 4.8): each texel holds the support vertex of its centre. A query
//! is one read, which is wrong wherever a texel has more than one answer. Hill climbing from there
//! corrects most answers, up to the plateaus of f32.

use glam::Vec3;

use crate::{
    query::{Rival, SupportQuery},
    rivals::{hill_climb::Graph, simd_scan},
    subject::Subject,
};

/// Six faces of resolution² texels.
#[derive(Clone, Debug)]
pub struct CubeMap {
    name: String,
    resolution: u32,
    /// Vertex indices, face by face, row by row.
    texels: Vec<u16>,
    vertices: Vec<Vec3>,
}

impl CubeMap {
    /// Queries the centre of every texel; `None` if vertex indices need more than 16 bits.
    pub fn new(subject: &Subject, resolution: u32) -> Option<Self> {
        let vertices: Vec<Vec3> = subject.vertices().collect();
        let _ = u16::try_from(vertices.len() - 1).ok()?;
        let blocks = simd_scan::blocks(&vertices);
        let texels = (0..6 * resolution * resolution).map(|texel| {
            let dir = centre(texel, resolution);
            // The padding of the last block repeats vertex 0.
            let place = simd_scan::best_here(&blocks, dir);
            if place.index() < vertices.len() { place.index() as u16 } else { 0 }
        });
        Some(Self { name: format!("cube map {resolution}"), resolution, texels: texels.collect(), vertices })
    }

    #[inline]
    fn lookup(&self, dir: Vec3) -> u32 {
        u32::from(self.texels[texel(dir, self.resolution) as usize])
    }

    fn texel_bytes(&self) -> usize {
        size_of_val(self.texels.as_slice())
    }
}

/// Texel of a direction: face 2·axis + sign, then row and column from the other two coordinates
/// divided by the largest.
#[inline]
fn texel(dir: Vec3, resolution: u32) -> u32 {
    let [ax, ay, az] = dir.abs().to_array();
    let z_wins = az > ax && az > ay;
    let y_wins = !z_wins && ay > ax;
    // Selects instead of branches: branch predictors cannot predict directions.
    let (largest, a, b, axis) = if z_wins {
        (dir.z, dir.x, dir.y, 2)
    } else if y_wins {
        (dir.y, dir.z, dir.x, 1)
    } else {
        (dir.x, dir.y, dir.z, 0)
    };
    let face = 2 * axis + u32::from(largest.is_sign_negative());
    let half = 0.5 * resolution as f32;
    let scale = half / largest.abs();
    // `as` saturates, and maps NaN to 0.
    let column = ((a * scale + half) as u32).min(resolution - 1);
    let row = ((b * scale + half) as u32).min(resolution - 1);
    (face * resolution + row) * resolution + column
}

/// Direction through the centre of a texel.
fn centre(texel: u32, resolution: u32) -> Vec3 {
    let middle = |step: u32| (2 * step + 1) as f32 / resolution as f32 - 1.0;
    let (face, row, column) = (texel / (resolution * resolution), texel / resolution % resolution, texel % resolution);
    let axis = (face / 2) as usize;
    let mut dir = [0.0; 3];
    dir[axis] = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
    dir[(axis + 1) % 3] = middle(column);
    dir[(axis + 2) % 3] = middle(row);
    Vec3::from_array(dir)
}

impl Rival for CubeMap {
    type Query<'a> = Lookup<'a>;

    fn name(&self) -> &str {
        &self.name
    }

    fn is_exact(&self) -> bool {
        false
    }

    fn index_bytes(&self) -> usize {
        self.texel_bytes()
    }

    fn footprint_bytes(&self) -> usize {
        self.texel_bytes() + size_of_val(self.vertices.as_slice())
    }

    fn query(&self) -> Lookup<'_> {
        Lookup { map: self }
    }

    fn duplicate(&self) -> Self {
        self.clone()
    }
}

/// See [`CubeMap`].
pub struct Lookup<'a> {
    map: &'a CubeMap,
}

impl SupportQuery for Lookup<'_> {
    #[inline]
    fn support(&mut self, dir: Vec3) -> Vec3 {
        self.map.vertices[self.map.lookup(dir) as usize]
    }
}

/// Hill climbing from the texel's vertex.
#[derive(Clone, Debug)]
pub struct CubeMapClimb {
    name: String,
    map: CubeMap,
    graph: Graph,
}

impl CubeMapClimb {
    /// `map` and `graph` are of the same subject.
    pub fn new(map: CubeMap, graph: Graph) -> Self {
        Self { name: format!("{} + climb", map.name), map, graph }
    }
}

impl Rival for CubeMapClimb {
    type Query<'a> = LookupClimb<'a>;

    fn name(&self) -> &str {
        &self.name
    }

    fn is_exact(&self) -> bool {
        false
    }

    fn index_bytes(&self) -> usize {
        self.map.texel_bytes() + self.graph.index_bytes()
    }

    fn footprint_bytes(&self) -> usize {
        self.map.footprint_bytes() + self.graph.footprint_bytes()
    }

    fn query(&self) -> LookupClimb<'_> {
        LookupClimb { map: &self.map, graph: &self.graph }
    }

    fn duplicate(&self) -> Self {
        self.clone()
    }
}

/// See [`CubeMapClimb`].
pub struct LookupClimb<'a> {
    map: &'a CubeMap,
    graph: &'a Graph,
}

impl SupportQuery for LookupClimb<'_> {
    #[inline]
    fn support(&mut self, dir: Vec3) -> Vec3 {
        self.graph.vertex(self.graph.climb(self.map.lookup(dir), dir))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn centres_are_in_their_texels() {
        for resolution in [1, 2, 7, 64] {
            for index in 0..6 * resolution * resolution {
                assert_eq!(texel(centre(index, resolution), resolution), index);
            }
        }
    }

    #[test]
    fn invalid_directions_stay_in_range() {
        let odd = [0.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.0, f32::MAX];
        for x in odd {
            for y in odd {
                for z in odd {
                    assert!(texel(Vec3::new(x, y, z), 64) < 6 * 64 * 64);
                }
            }
        }
    }
}
