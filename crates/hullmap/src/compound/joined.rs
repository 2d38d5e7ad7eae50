//! Several unions that meet, as one: the tiles of a level, each a mesh of its own.

#![forbid(unsafe_code)]

use glam::DVec3;

use super::seams::{Neighbour, Union};
use crate::pose::Pose;

/// One of several unions that meet.
#[derive(Clone, Copy)]
pub struct Tile<'u> {
    /// The union, as [`seams::union_of`](super::seams::union_of) returns it.
    pub union: &'u dyn Union,
    /// Number of its parts.
    pub parts: usize,
    /// Its pose in a frame that all tiles share.
    pub place: Pose,
}

/// Several unions that meet, as one [`Union`]: edges where two of them meet are edges inside it.
///
/// Each tile keeps manifolds of its own, updated by
/// [`CompoundManifolds::update_joined`](super::CompoundManifolds::update_joined). An engine finds
/// the tiles near a body with its broad phase.
///
/// # Complexity
/// A query tests all tiles in turn, so join the tiles near a body, not all tiles of a world.
///
/// # Examples
/// Two floors that meet at x = 0, and a die that slides from one to the other, 1 mm deep. The
/// shortest way out of the right floor is sideways, but the floors are one:
/// ```
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use hullmap::compound::seams;
/// use hullmap::compound::{Joined, Tile};
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::Cuboid;
/// use hullmap::{CompoundManifolds, ManifoldSettings, Pose, TriangleMesh};
/// # use hullmap_bake::triangle_mesh::{Triangles, bake_triangle_mesh, write_triangle_mesh};
/// # let floor = |x: f32| -> Result<TriangleMesh, Box<dyn std::error::Error>> {
/// #     let positions = [[x, -9.0, 0.0], [x + 9.0, -9.0, 0.0], [x + 9.0, 9.0, 0.0], [x, 9.0, 0.0]];
/// #     let corners = [[0, 1, 2], [0, 2, 3]];
/// #     let triangles = Triangles { positions: &positions, corners: &corners, materials: &[] };
/// #     Ok(TriangleMesh::from_bytes(&write_triangle_mesh(bake_triangle_mesh(&triangles)?, &Default::default())?)?)
/// # };
///
/// let (left, right) = (floor(-9.0)?, floor(0.0)?);
/// let unions = (seams::union_of(&left), seams::union_of(&right));
/// let tiles = [
///     Tile { union: &unions.0, parts: left.triangle_count(), place: Pose::IDENTITY },
///     Tile { union: &unions.1, parts: right.triangle_count(), place: Pose::IDENTITY },
/// ];
/// let (die, settings) = (Cuboid::new(DVec3::splat(0.5))?, ManifoldSettings::default());
/// let at = Pose::from_translation(DVec3::new(-0.4995, 0.3, 0.499))?;
/// let mut manifolds = CompoundManifolds::new(8);
/// manifolds.update(&right, &die, at, &settings);
/// assert!(manifolds.iter().any(|(_, manifold)| manifold.normal().z < 0.5));
/// manifolds.update_joined(&Joined::new(&tiles), 1, &right, &die, at, &settings);
/// assert!(manifolds.iter().all(|(_, manifold)| manifold.normal().distance(DVec3::Z) < 1e-9));
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy)]
pub struct Joined<'u> {
    tiles: &'u [Tile<'u>],
}

impl<'u> Joined<'u> {
    /// The union of `tiles`.
    pub fn new(tiles: &'u [Tile<'u>]) -> Self {
        Self { tiles }
    }

    /// Index of the first part of a tile among the parts of all tiles, and the pose of the tile;
    /// `None` if there is no such tile.
    pub(super) fn tile(&self, tile: usize) -> Option<(usize, Pose)> {
        let before = self.tiles.get(..tile)?.iter().map(|tile| tile.parts).sum();
        Some((before, self.tiles.get(tile)?.place))
    }

    /// The tile of a part, and the index of the part in it.
    fn of_part(&self, part: usize) -> Option<(&Tile<'u>, usize)> {
        let mut before = 0;
        for tile in self.tiles {
            if part < before + tile.parts {
                return Some((tile, part - before));
            }
            before += tile.parts;
        }
        None
    }
}

impl Union for Joined<'_> {
    fn any_near(&self, point: DVec3, reach: f64, test: &mut dyn FnMut(Neighbour<'_>) -> bool) -> bool {
        let mut before = 0;
        for tile in self.tiles {
            let local = tile.place.inverse().transform_point(point);
            let found = tile.union.any_near(local, reach, &mut |near| {
                let Ok(place) = tile.place.compose(near.place) else { return false };
                test(Neighbour { index: before + near.index, shape: near.shape, place })
            });
            if found {
                return true;
            }
            before += tile.parts;
        }
        false
    }

    fn face_towards(&self, part: usize, dir: DVec3) -> Option<DVec3> {
        let (tile, part) = self.of_part(part)?;
        let normal = tile.union.face_towards(part, tile.place.inverse_transform_vector(dir))?;
        Some(tile.place.transform_vector(normal))
    }

    fn faces_near(&self, part: usize, vertex: u32, visit: &mut dyn FnMut(DVec3, DVec3)) {
        let Some((tile, part)) = self.of_part(part) else { return };
        tile.union.faces_near(part, vertex, &mut |normal, point| {
            visit(tile.place.transform_vector(normal), tile.place.transform_point(point));
        });
    }
}
