//! A tile of a surface: one triangle mesh or height field, and where it is.

#[cfg(feature = "dispatcher")]
use hullmap::EdgeClass;
pub use hullmap::compound::SharedSheet as Sheet;
#[cfg(feature = "dispatcher")]
use hullmap::compound::seams::{self, Neighbour, Union};
use hullmap::geometry::{Geometry, Visitor};
use hullmap::glam::DVec3;
use hullmap::shapes::Triangle;

use super::super::convert::{narrow, narrow_pose, wide_pose};
use super::super::parry;
use super::super::parry::bounding_volume::{Aabb, BoundingVolume as _};
use super::super::parry::math::{Pose, Real};

/// Evaluates `$answer` with `$sheet` bound to the mesh or the field of `$tile`, one-sided if the
/// tile is.
macro_rules! on_sheet {
    ($tile:expr, $sheet:ident => $answer:expr) => {
        if $tile.is_one_sided() {
            let $sheet = &hullmap::compound::OneSided::new($tile.sheet());
            $answer
        } else {
            let $sheet = $tile.sheet();
            $answer
        }
    };
}
#[cfg(feature = "dispatcher")]
pub(in super::super) use on_sheet;

impl Geometry for SurfaceTile {
    fn visit<V: Visitor>(&self, visitor: V) -> V::Output {
        on_sheet!(self, sheet => sheet.visit(visitor))
    }
}

/// A mesh or a field of a [`BakedSurface`](super::BakedSurface).
#[derive(Clone, Debug)]
pub struct SurfaceTile {
    sheet: Sheet,
    is_one_sided: bool,
    /// In the frame of the shape.
    place: hullmap::Pose,
    /// `place` in parry's precision.
    pose: Pose,
    /// Index of the first triangle among the triangles of all tiles.
    first: usize,
    /// The box in the frame of the shape.
    bounds: Aabb,
}

impl SurfaceTile {
    /// Margin of boxes relative to the largest coordinate, for the rounding errors of f32.
    pub(super) const MARGIN: Real = 1e-6;

    pub(super) fn new(sheet: Sheet) -> Self {
        let place = hullmap::Pose::IDENTITY;
        let bounds = bounds(&sheet, &Pose::IDENTITY);
        Self { sheet, is_one_sided: false, place, pose: Pose::IDENTITY, first: 0, bounds }
    }

    /// The tile in the frame that `pose` maps to, as one whose first triangle has the number
    /// `first`; `None` if the pose is not finite, or the tile too far away.
    pub(super) fn moved(&self, pose: &Pose, first: usize) -> Option<Self> {
        let place = wide_pose(pose)?.compose(self.place).ok()?;
        let pose = narrow_pose(&place);
        let bounds = bounds(&self.sheet, &pose);
        Some(Self { place, pose, first, bounds, ..self.clone() })
    }

    pub(super) fn one_sided(&self) -> Self {
        Self { is_one_sided: true, ..self.clone() }
    }

    /// The mesh or the field.
    pub fn sheet(&self) -> &Sheet {
        &self.sheet
    }

    /// Whether its triangles collide on their fronts alone.
    pub fn is_one_sided(&self) -> bool {
        self.is_one_sided
    }

    /// Its pose in the frame of the shape, in f64.
    pub fn place(&self) -> hullmap::Pose {
        self.place
    }

    /// Number of its triangles, including the triangles of holes.
    pub fn triangle_count(&self) -> usize {
        self.sheet.triangle_count()
    }

    /// Material of a triangle, from the bake; `None` in a hole, and beyond the last triangle.
    pub fn material(&self, triangle: usize) -> Option<u16> {
        match &self.sheet {
            Sheet::Mesh(mesh) => mesh.material(triangle),
            Sheet::Field(field) => field.material(triangle),
        }
    }

    /// Index of the first triangle among the triangles of all tiles.
    pub fn first(&self) -> usize {
        self.first
    }

    /// The box in the frame of the shape, with a margin.
    pub(in super::super) fn bounds(&self) -> &Aabb {
        &self.bounds
    }

    /// The pose in parry's precision; `None` for the identity.
    pub(super) fn pose(&self) -> Option<&Pose> {
        (self.place != hullmap::Pose::IDENTITY).then_some(&self.pose)
    }

    /// A triangle in the frame of the tile; `None` in a hole, and beyond the last triangle.
    pub(in super::super) fn triangle(&self, triangle: usize) -> Option<Triangle> {
        self.sheet.triangle(triangle)
    }

    pub(in super::super) fn parry_triangle(&self, triangle: usize) -> Option<parry::shape::Triangle> {
        let [a, b, c] = self.triangle(triangle)?.corners().map(narrow);
        Some(parry::shape::Triangle::new(a, b, c))
    }

    /// Normal of a triangle's front, in the frame of the shape; `None` in a hole, and without area.
    pub(in super::super) fn normal(&self, triangle: usize) -> Option<DVec3> {
        Some(self.place.transform_vector(self.local_normal(triangle)?))
    }

    /// Normal of a triangle's front in the frame of the tile, if only its front collides.
    #[cfg(feature = "dispatcher")]
    pub(in super::super) fn front(&self, triangle: usize) -> Option<DVec3> {
        if self.is_one_sided { self.local_normal(triangle) } else { None }
    }

    /// Normal of a triangle's front in the frame of the tile; `None` in a hole, and without area.
    pub(in super::super) fn local_normal(&self, triangle: usize) -> Option<DVec3> {
        self.sheet.normal(triangle)
    }

    /// Classes of the edges of a triangle, from corner i to the next one.
    #[cfg(feature = "dispatcher")]
    pub(in super::super) fn edge_classes(&self, triangle: usize) -> Option<[EdgeClass; 3]> {
        match &self.sheet {
            Sheet::Mesh(mesh) => mesh.edge_classes(triangle),
            Sheet::Field(field) => field.edge_classes(triangle),
        }
    }

    /// Index of a triangle among the triangles of all tiles.
    pub(in super::super) fn subshape(&self, triangle: usize) -> u32 {
        u32::try_from(self.first + triangle).unwrap_or(u32::MAX)
    }
}

fn bounds(sheet: &Sheet, pose: &Pose) -> Aabb {
    let [low, high] = match sheet {
        Sheet::Mesh(mesh) => mesh.bounds().map(|corner| corner.as_dvec3()),
        Sheet::Field(field) => field.bounds(),
    };
    let tight = Aabb::new(narrow(low), narrow(high)).transform_by(pose);
    let largest = tight.mins.abs().max(tight.maxs.abs()).max_element();
    tight.loosened(SurfaceTile::MARGIN * largest)
}

#[cfg(feature = "dispatcher")]
impl Union for SurfaceTile {
    fn any_near(&self, point: DVec3, reach: f64, test: &mut dyn FnMut(Neighbour<'_>) -> bool) -> bool {
        on_sheet!(self, sheet => seams::union_of(sheet).any_near(point, reach, test))
    }

    fn face_towards(&self, part: usize, dir: DVec3) -> Option<DVec3> {
        on_sheet!(self, sheet => seams::union_of(sheet).face_towards(part, dir))
    }

    fn faces_near(&self, part: usize, vertex: u32, visit: &mut dyn FnMut(DVec3, DVec3)) {
        on_sheet!(self, sheet => seams::union_of(sheet).faces_near(part, vertex, visit))
    }
}
