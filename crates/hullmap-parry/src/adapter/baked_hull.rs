//! `BakedHull`: a hull of a pack, possibly scaled, as the type that implements parry's traits.

use hullmap::glam::DVec3;
use hullmap::shapes::Scaled;
use hullmap::{Hull, ShapeError, SharedHull, SupportPoint};

use super::convert::wide;
use super::parry::math::Vector;
use super::parry::shape::SharedShape;

/// A baked hull as a parry shape.
///
/// It keeps its pack alive, which clones share. Use it directly, or as a `SharedShape` by `into()`.
/// Points, directions and lengths are in the local frame: the hull's, multiplied by the
/// [`scale`](Self::scale).
#[derive(Clone, Debug)]
pub struct BakedHull {
    form: Form,
    part_mass: PartMass,
}

/// Which mass a hull has as a parry shape.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum PartMass {
    /// Its own mass; for the hull of a whole mesh, the mesh's mass, if the pack records it.
    #[default]
    Hull,
    /// The mass of the mesh whose parts are all in one compound. The first part has it.
    Mesh,
    /// No mass: the first part in the compound has the mass of all.
    Nothing,
}

/// The shape that answers queries.
#[derive(Clone, Debug)]
pub(super) enum Form {
    Plain(SharedHull),
    Scaled(Scaled<SharedHull>),
}

macro_rules! on_form {
    ($hull:expr, $shape:ident => $answer:expr) => {
        match $hull.form() {
            Form::Plain($shape) => $answer,
            Form::Scaled($shape) => $answer,
        }
    };
}
pub(super) use on_form;

impl BakedHull {
    /// The shape of `hull`.
    pub fn new(hull: SharedHull) -> Self {
        Self { form: Form::Plain(hull), part_mass: PartMass::Hull }
    }

    /// This shape, scaled along the axes of its frame in addition to its present scale. A negative
    /// scale mirrors it. O(1): a scaled hull uses the index of the original.
    ///
    /// # Errors
    /// [`ShapeError::Scale`] if a resulting scale is NaN, zero, or too small or large for f32.
    pub fn scaled(&self, scale: Vector) -> Result<Self, ShapeError> {
        self.scaled_by(wide(scale) * self.scale_factors())
    }

    pub(super) fn scaled_by(&self, scale: DVec3) -> Result<Self, ShapeError> {
        let form = if scale == DVec3::ONE {
            Form::Plain(self.shared_hull().clone())
        } else {
            Form::Scaled(Scaled::new(self.shared_hull().clone(), scale)?)
        };
        Ok(Self { form, part_mass: self.part_mass })
    }

    /// Which mass the shape has. A mesh in several parts has one: see [`union`](super::union).
    pub fn part_mass(&self) -> PartMass {
        self.part_mass
    }

    pub(super) fn set_part_mass(&mut self, part_mass: PartMass) {
        self.part_mass = part_mass;
    }

    /// The hull, without the scale.
    pub fn hull(&self) -> &Hull<'_> {
        self.shared_hull().hull()
    }

    /// The hull with its handle to the pack, without the scale.
    pub fn shared_hull(&self) -> &SharedHull {
        match &self.form {
            Form::Plain(hull) => hull,
            Form::Scaled(scaled) => scaled.shape(),
        }
    }

    /// The scale along each axis; ones if the hull is not scaled.
    pub fn scale(&self) -> Vector {
        super::convert::narrow(self.scale_factors())
    }

    pub(super) fn scale_factors(&self) -> DVec3 {
        match &self.form {
            Form::Plain(_) => DVec3::ONE,
            Form::Scaled(scaled) => scaled.scale(),
        }
    }

    #[inline(always)]
    pub(super) fn form(&self) -> &Form {
        &self.form
    }

    /// The face whose normal is closest to `dir`; `None` below rank 2. The normals of a scaled hull
    /// are the original ones divided by the scale, so the direction is multiplied by it.
    pub(super) fn face_towards(&self, dir: DVec3) -> Option<u32> {
        self.hull().face_towards(dir * self.scale_factors())
    }

    pub(super) fn face_normal(&self, face: u32) -> Option<DVec3> {
        let normal = self.hull().face_normal(face)? / self.scale_factors();
        normal.try_normalize()
    }
}

impl From<SharedHull> for BakedHull {
    fn from(hull: SharedHull) -> Self {
        Self::new(hull)
    }
}

impl From<BakedHull> for SharedShape {
    fn from(hull: BakedHull) -> Self {
        SharedShape::new(hull)
    }
}

impl hullmap::SupportMap for BakedHull {
    #[inline(always)]
    fn support_point(&self, dir: DVec3) -> SupportPoint {
        on_form!(self, shape => shape.support_point(dir))
    }

    fn interior_point(&self) -> DVec3 {
        on_form!(self, shape => shape.interior_point())
    }

    fn inner_radius(&self) -> f64 {
        on_form!(self, shape => shape.inner_radius())
    }

    fn outer_radius(&self) -> f64 {
        on_form!(self, shape => shape.outer_radius())
    }

    fn support_error(&self) -> f64 {
        on_form!(self, shape => shape.support_error())
    }

    #[inline]
    fn point(&self, feature: u32) -> Option<DVec3> {
        on_form!(self, shape => shape.point(feature))
    }

    fn polytope_vertex(&self, index: u32) -> Option<DVec3> {
        on_form!(self, shape => shape.polytope_vertex(index))
    }

    #[inline]
    fn facets(&self) -> Option<hullmap::Facets<'_>> {
        on_form!(self, shape => shape.facets())
    }

    #[inline]
    fn support_point_from(&self, dir: DVec3, hint: u32) -> SupportPoint {
        on_form!(self, shape => shape.support_point_from(dir, hint))
    }
}
