//! `BakedSurface`: static ground that keeps its triangles, as a parry shape. It consists of
//! triangle meshes and height fields, which may meet.

mod composite;
mod debug;
mod point;
mod ray;
mod shape;
mod tile;

use std::sync::{Arc, OnceLock};

use super::parry::bounding_volume::{Aabb, BoundingVolume as _};
use super::parry::math::Pose;
use super::parry::partitioning::Bvh;
use super::parry::shape::SharedShape;
#[cfg(feature = "dispatcher")]
pub(super) use tile::on_sheet;
pub use tile::{Sheet, SurfaceTile};

/// A static triangle mesh or height field as a parry shape, or several that meet.
///
/// It shares its files with its clones. It is a shape of fixed bodies: it has no mass. Points,
/// directions and lengths are in the frame of the mesh or the field. Heights of a field are along
/// +z: rotate the collider if another axis is up.
///
/// Triangles are thin. They have no inside, even if a mesh is closed.
///
/// With `HullDispatcher`, hullmap answers queries with hulls, compounds of them, and primitives:
/// normals at internal edges are normals of the surface, and a body has few contact points. parry's
/// default dispatcher solves each triangle alone, with a tree that it builds at the first query.
///
/// # Tiles that meet
/// Rapier passes one pair of colliders at a time to the dispatcher, without the colliders beside
/// it. So tiles that meet should be one shape: see [`joined`](Self::joined).
///
/// # Examples
/// ```
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # use hullmap_bake::triangle_mesh::{Triangles, bake_triangle_mesh, write_triangle_mesh};
/// # let positions = [[-9.0, 0.0, -9.0], [-9.0, 0.0, 9.0], [9.0, 0.0, 9.0], [9.0, 0.0, -9.0]];
/// # let triangles = Triangles { positions: &positions, corners: &[[0, 1, 2], [0, 2, 3]], materials: &[] };
/// # let file = write_triangle_mesh(bake_triangle_mesh(&triangles)?, &Default::default())?;
/// use std::sync::Arc;
/// use hullmap::TriangleMesh;
/// use hullmap_parry::BakedSurface;
/// use parry3d::math::{Pose, Vector};
/// use parry3d::query::{self, Ray, RayCast};
/// use parry3d::shape::Ball;
///
/// // A square of two triangles in the plane y = 0.
/// let level = TriangleMesh::from_bytes(&file)?; // or TriangleMesh::open(path)
/// let level = BakedSurface::new(Arc::new(level));
/// let above = Pose::translation(1.0, 2.0, 0.5);
/// let distance = query::distance(&Pose::IDENTITY, &level, &above, &Ball::new(0.5))?.distance;
/// assert!((distance - 1.5).abs() < 1e-6);
///
/// let down = Ray::new(Vector::new(1.0, 2.0, 0.5), -Vector::Y);
/// let hit = level.cast_local_ray_and_get_normal(&down, 9.0, true).ok_or("no hit")?;
/// assert!((hit.time_of_impact - 2.0).abs() < 1e-6 && hit.normal.y > 0.999);
/// let (tile, triangle) = level.locate(hit.subshape).ok_or("no such triangle")?;
/// assert_eq!(tile.material(triangle), Some(0));
/// # Ok(())
/// # }
/// ```
#[derive(Clone)]
pub struct BakedSurface {
    content: Arc<Content>,
}

struct Content {
    tiles: Vec<SurfaceTile>,
    bounds: Aabb,
    /// parry's tree of all triangles, which only its own algorithms need.
    tree: OnceLock<Bvh>,
}

/// Why surfaces cannot be joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum JoinError {
    /// There is no surface.
    NoTiles,
    /// A pose is not finite, or a tile is too far away.
    Pose,
    /// There are more than 2³² triangles: parry numbers them in 32 bits.
    TooManyTriangles,
}

impl std::fmt::Display for JoinError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::NoTiles => "there are no surfaces to join: pass at least one",
            Self::Pose => "the pose of a surface is not finite, or too far away: move it nearer",
            Self::TooManyTriangles => "the surfaces have more than 4,294,967,296 triangles: join fewer of them",
        })
    }
}

impl std::error::Error for JoinError {}

impl BakedSurface {
    /// The shape of a triangle mesh or a height field, which collides on both sides.
    pub fn new(sheet: impl Into<Sheet>) -> Self {
        Self::of_tiles(vec![SurfaceTile::new(sheet.into())])
    }

    /// Several surfaces that meet, each with its pose, as one shape without edges between them,
    /// over which bodies would stumble. Subshapes are numbered through all tiles: see
    /// [`locate`](Self::locate). A query compares the boxes of all tiles.
    ///
    /// # Errors
    /// See [`JoinError`].
    pub fn joined(surfaces: impl IntoIterator<Item = (Pose, Self)>) -> Result<Self, JoinError> {
        let (mut tiles, mut first) = (Vec::new(), 0_usize);
        for (at, surface) in surfaces {
            for tile in surface.tiles() {
                let tile = tile.moved(&at, first).ok_or(JoinError::Pose)?;
                first = first.saturating_add(tile.triangle_count());
                tiles.push(tile);
            }
        }
        if tiles.is_empty() {
            return Err(JoinError::NoTiles);
        }
        if first as u64 > 1 << 32 {
            return Err(JoinError::TooManyTriangles);
        }
        Ok(Self::of_tiles(tiles))
    }

    /// A copy whose triangles collide on their fronts alone: see
    /// [`OneSided`](hullmap::compound::OneSided). With parry's default dispatcher, contacts and
    /// casts of shapes have both sides, and rays one.
    #[must_use]
    pub fn one_sided(&self) -> Self {
        Self::of_tiles(self.tiles().iter().map(SurfaceTile::one_sided).collect())
    }

    fn of_tiles(tiles: Vec<SurfaceTile>) -> Self {
        let boxes = tiles.iter().map(|tile| *tile.bounds());
        let bounds = boxes.reduce(|all, one| all.merged(&one)).unwrap_or_else(Aabb::new_invalid);
        Self { content: Arc::new(Content { tiles, bounds, tree: OnceLock::new() }) }
    }

    /// The meshes and fields of the surface.
    pub fn tiles(&self) -> &[SurfaceTile] {
        &self.content.tiles
    }

    /// Number of triangles of all tiles, including the triangles of holes.
    pub fn triangle_count(&self) -> usize {
        self.tiles().iter().map(SurfaceTile::triangle_count).sum()
    }

    /// The tile of a subshape, and the index of the triangle in its file, in O(log n) for n tiles;
    /// `None` beyond the last triangle. parry's answers and contact manifolds name triangles as
    /// subshapes.
    pub fn locate(&self, subshape: u32) -> Option<(&SurfaceTile, usize)> {
        let subshape = subshape as usize;
        let after = self.tiles().partition_point(|tile| tile.first() <= subshape);
        let tile = self.tiles().get(after.checked_sub(1)?)?;
        let triangle = subshape - tile.first();
        (triangle < tile.triangle_count()).then_some((tile, triangle))
    }
}

impl std::fmt::Debug for BakedSurface {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("BakedSurface").field("tiles", &self.content.tiles).finish_non_exhaustive()
    }
}

impl From<BakedSurface> for SharedShape {
    fn from(surface: BakedSurface) -> Self {
        SharedShape::new(surface)
    }
}
