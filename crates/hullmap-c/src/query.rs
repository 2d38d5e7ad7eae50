//! A query of two shapes of any kind: finds the function of `hullmap` for the two kinds.
//!
//! Two hulls take the code that the compiler has specialised for hulls. All other convex shapes go
//! through the table of `dyn Shape`, whose answers have the same bits.

#![forbid(unsafe_code)]

use std::mem::MaybeUninit;

use hullmap::compound::{self, CompoundAnswer, Parts, SharedSheet, half_space};
use hullmap::glam::DVec3;
use hullmap::shapes::HalfSpace;
use hullmap::{CastSettings, Compound, ManifoldSettings, Motion, Pose, Settings};

use crate::failure::{Failure, Fallible};
use crate::handles::{Kind, Memory, Points, Shape};
use crate::types;

/// A query, for each kind of pair.
pub(crate) trait ShapeQuery {
    type Answer;

    fn convex<A, B>(self, a: &A, b: &B) -> Fallible<Self::Answer>
    where
        A: hullmap::Shape + ?Sized,
        B: hullmap::Shape + ?Sized;

    fn parts<A: Parts + ?Sized, B: Parts + ?Sized>(self, a: &A, b: &B) -> Fallible<Self::Answer>;

    fn plane<B: hullmap::Shape + ?Sized>(self, a: &HalfSpace, b: &B) -> Fallible<Self::Answer>;

    fn plane_and_parts<B: Parts + ?Sized>(self, a: &HalfSpace, b: &B) -> Fallible<Self::Answer>;
}

/// Checks that the two kinds have queries at all.
pub(crate) fn check_sides(b: &Shape) -> Fallible<()> {
    if matches!(b.kind, Kind::HalfSpace(_)) { Err(half_space_as_b()) } else { Ok(()) }
}

#[inline(always)]
pub(crate) fn run<Q: ShapeQuery>(a: &Shape, b: &Shape, query: Q) -> Fallible<Q::Answer> {
    match (&a.kind, &b.kind) {
        (Kind::Hull(a), Kind::Hull(b)) => query.convex(a.hull(), b.hull()),
        (Kind::HalfSpace(a), Kind::Compound(b)) => query.plane_and_parts(a, &Compound::new(b)),
        (Kind::Compound(a), Kind::Compound(b)) => query.parts(&Compound::new(a), &Compound::new(b)),
        // As a compound of one hull, which has more stages before the solver than other shapes.
        (Kind::Compound(a), Kind::Hull(b)) => query.parts(&Compound::new(a), &Compound::from(*b.hull())),
        (Kind::Hull(a), Kind::Compound(b)) => query.parts(&Compound::from(*a.hull()), &Compound::new(b)),
        (Kind::Compound(a), Kind::Convex(b)) => query.parts(&Compound::new(a), convex(&**b)),
        (Kind::Convex(a), Kind::Compound(b)) => query.parts(convex(&**a), &Compound::new(b)),
        (Kind::HalfSpace(a), Kind::Sheet(b)) => query.plane_and_parts(a, b),
        (Kind::Sheet(a), Kind::Sheet(b)) => query.parts(a, b),
        (Kind::Sheet(a), Kind::Compound(b)) => query.parts(a, &Compound::new(b)),
        (Kind::Compound(a), Kind::Sheet(b)) => query.parts(&Compound::new(a), b),
        (Kind::Sheet(a), Kind::Hull(b)) => query.parts(a, &Compound::from(*b.hull())),
        (Kind::Hull(a), Kind::Sheet(b)) => query.parts(&Compound::from(*a.hull()), b),
        (Kind::Sheet(a), Kind::Convex(b)) => query.parts(a, convex(&**b)),
        (Kind::Convex(a), Kind::Sheet(b)) => query.parts(convex(&**a), b),
        (a, b) => match (a, a.convex(), b.convex()) {
            (Kind::HalfSpace(a), _, Some(b)) => query.plane(a, b),
            (_, Some(a), Some(b)) => query.convex(a, b),
            _ => Err(half_space_as_b()),
        },
    }
}

/// Without the marks for threads, so that there is one type for all shapes.
fn convex(shape: &(dyn hullmap::Shape + Send + Sync)) -> &dyn hullmap::Shape {
    shape
}

#[cold]
fn half_space_as_b() -> Failure {
    let message = "B is a half-space: pass it as A, with the inverse pose. Two half-spaces have no query";
    Failure::unsupported(message)
}

struct Intersects<'q>(Pose, &'q mut Memory);

impl ShapeQuery for Intersects<'_> {
    type Answer = types::Intersection;

    fn convex<A, B>(self, a: &A, b: &B) -> Fallible<Self::Answer>
    where
        A: hullmap::Shape + ?Sized,
        B: hullmap::Shape + ?Sized,
    {
        Ok(types::Intersection::new(hullmap::intersects(a, b, self.0, &mut self.1.convex), [0, 0]))
    }

    fn parts<A: Parts + ?Sized, B: Parts + ?Sized>(self, a: &A, b: &B) -> Fallible<Self::Answer> {
        let CompoundAnswer { answer, hulls, .. } = compound::intersects(a, b, self.0, self.1.compound());
        Ok(types::Intersection::new(answer, hulls))
    }

    fn plane<B: hullmap::Shape + ?Sized>(self, a: &HalfSpace, b: &B) -> Fallible<Self::Answer> {
        Ok(types::Intersection::new(a.intersects(b, self.0), [0, 0]))
    }

    fn plane_and_parts<B: Parts + ?Sized>(self, a: &HalfSpace, b: &B) -> Fallible<Self::Answer> {
        let CompoundAnswer { answer, hulls, .. } = half_space::intersects(a, b, self.0);
        Ok(types::Intersection::new(answer, hulls))
    }
}

/// Whether two shapes share a point.
#[inline(always)]
pub(crate) fn intersects(a: &Shape, b: &Shape, b_in_a: Pose, memory: &mut Memory) -> Fallible<types::Intersection> {
    run(a, b, Intersects(b_in_a, memory))
}

struct Distance<'q>(Pose, &'q Settings, &'q mut Memory);

impl ShapeQuery for Distance<'_> {
    type Answer = types::Distance;

    fn convex<A, B>(self, a: &A, b: &B) -> Fallible<Self::Answer>
    where
        A: hullmap::Shape + ?Sized,
        B: hullmap::Shape + ?Sized,
    {
        Ok(types::Distance::new(hullmap::distance(a, b, self.0, self.1, &mut self.2.convex), [0, 0]))
    }

    fn parts<A: Parts + ?Sized, B: Parts + ?Sized>(self, a: &A, b: &B) -> Fallible<Self::Answer> {
        let CompoundAnswer { answer, hulls, .. } = compound::distance(a, b, self.0, self.1, self.2.compound());
        Ok(types::Distance::new(answer, hulls))
    }

    fn plane<B: hullmap::Shape + ?Sized>(self, a: &HalfSpace, b: &B) -> Fallible<Self::Answer> {
        Ok(types::Distance::new(a.distance(b, self.0), [0, 0]))
    }

    fn plane_and_parts<B: Parts + ?Sized>(self, a: &HalfSpace, b: &B) -> Fallible<Self::Answer> {
        let CompoundAnswer { answer, hulls, .. } = half_space::distance(a, b, self.0);
        Ok(types::Distance::new(answer, hulls))
    }
}

/// Distance of two shapes.
#[inline(always)]
pub(crate) fn distance(
    a: &Shape,
    b: &Shape,
    b_in_a: Pose,
    settings: &Settings,
    memory: &mut Memory,
) -> Fallible<types::Distance> {
    run(a, b, Distance(b_in_a, settings, memory))
}

struct Contact<'q>(Pose, &'q Settings, &'q mut Memory);

impl ShapeQuery for Contact<'_> {
    type Answer = types::Contact;

    fn convex<A, B>(self, a: &A, b: &B) -> Fallible<Self::Answer>
    where
        A: hullmap::Shape + ?Sized,
        B: hullmap::Shape + ?Sized,
    {
        Ok(types::Contact::new(hullmap::contact(a, b, self.0, self.1, &mut self.2.convex), [0, 0]))
    }

    fn parts<A: Parts + ?Sized, B: Parts + ?Sized>(self, a: &A, b: &B) -> Fallible<Self::Answer> {
        let found = compound::contact(a, b, self.0, self.1, self.2.compound());
        Ok(found.map_or_else(types::Contact::separated, |found| types::Contact::new(found.answer, found.hulls)))
    }

    fn plane<B: hullmap::Shape + ?Sized>(self, a: &HalfSpace, b: &B) -> Fallible<Self::Answer> {
        Ok(types::Contact::new(a.contact(b, self.0), [0, 0]))
    }

    fn plane_and_parts<B: Parts + ?Sized>(self, a: &HalfSpace, b: &B) -> Fallible<Self::Answer> {
        let CompoundAnswer { answer, hulls, .. } = half_space::contact(a, b, self.0);
        Ok(types::Contact::new(answer, hulls))
    }
}

/// Contact of two shapes.
#[inline(always)]
pub(crate) fn contact(
    a: &Shape,
    b: &Shape,
    b_in_a: Pose,
    settings: &Settings,
    memory: &mut Memory,
) -> Fallible<types::Contact> {
    run(a, b, Contact(b_in_a, settings, memory))
}

struct Cast<'q>(Pose, Motion, &'q CastSettings, &'q mut Memory);

impl ShapeQuery for Cast<'_> {
    type Answer = types::Impact;

    fn convex<A, B>(self, a: &A, b: &B) -> Fallible<Self::Answer>
    where
        A: hullmap::Shape + ?Sized,
        B: hullmap::Shape + ?Sized,
    {
        Ok(types::Impact::new(hullmap::cast(a, b, self.0, self.1, self.2, &mut self.3.convex), [0, 0]))
    }

    fn parts<A: Parts + ?Sized, B: Parts + ?Sized>(self, a: &A, b: &B) -> Fallible<Self::Answer> {
        let CompoundAnswer { answer, hulls, .. } = compound::cast(a, b, self.0, self.1, self.2, self.3.compound());
        Ok(types::Impact::new(answer, hulls))
    }

    fn plane<B: hullmap::Shape + ?Sized>(self, a: &HalfSpace, b: &B) -> Fallible<Self::Answer> {
        Ok(types::Impact::new(a.cast(b, self.0, self.1, self.2), [0, 0]))
    }

    fn plane_and_parts<B: Parts + ?Sized>(self, a: &HalfSpace, b: &B) -> Fallible<Self::Answer> {
        let CompoundAnswer { answer, hulls, .. } = half_space::cast(a, b, self.0, self.1, self.2);
        Ok(types::Impact::new(answer, hulls))
    }
}

/// When the moving shape B first meets A.
pub(crate) fn cast(
    a: &Shape,
    b: &Shape,
    b_in_a: Pose,
    motion: Motion,
    settings: &CastSettings,
    memory: &mut Memory,
) -> Fallible<types::Impact> {
    run(a, b, Cast(b_in_a, motion, settings, memory))
}

struct Update<'q>(Pose, &'q ManifoldSettings, &'q mut Points);

impl ShapeQuery for Update<'_> {
    type Answer = ();

    fn convex<A, B>(self, a: &A, b: &B) -> Fallible<()>
    where
        A: hullmap::Shape + ?Sized,
        B: hullmap::Shape + ?Sized,
    {
        let Self(b_in_a, settings, points) = self;
        let found = points.convex.update(a, b, b_in_a, settings, &mut points.cache);
        points.show_convex(&found);
        Ok(())
    }

    fn parts<A: Parts + ?Sized, B: Parts + ?Sized>(self, a: &A, b: &B) -> Fallible<()> {
        let counts = self.2.compound().update(a, b, self.0, self.1);
        self.2.show_compound(counts);
        Ok(())
    }

    fn plane<B: hullmap::Shape + ?Sized>(self, a: &HalfSpace, b: &B) -> Fallible<()> {
        let found = self.2.convex.update_half_space(a, b, self.0, self.1);
        self.2.show_convex(&found);
        Ok(())
    }

    fn plane_and_parts<B: Parts + ?Sized>(self, a: &HalfSpace, b: &B) -> Fallible<()> {
        let counts = self.2.compound().update_half_space(a, b, self.0, self.1);
        self.2.show_compound(counts);
        Ok(())
    }
}

/// Updates the points of a manifold.
pub(crate) fn update(
    a: &Shape,
    b: &Shape,
    b_in_a: Pose,
    settings: &ManifoldSettings,
    points: &mut Points,
) -> Fallible<()> {
    points.read_back();
    run(a, b, Update(b_in_a, settings, points))
}

#[cold]
fn not_for_sheets(sheet: &SharedSheet, query: &str) -> Failure {
    let (name, of_triangles) = match sheet {
        SharedSheet::Mesh(_) => (sheet.name(), "hullmap_triangle_mesh_triangle"),
        SharedSheet::Field(_) => (sheet.name(), "hullmap_height_field_triangle"),
    };
    let remedy = "query the distance of a sphere of radius 0, or its triangles one by one";
    Failure::unsupported(format_args!("{name} has no {query}: {remedy} ({of_triangles})"))
}

#[cold]
fn not_for(kind: &str, query: &str) -> Failure {
    Failure::unsupported(format_args!("{kind} has no {query}: query its hulls one by one (hullmap_shape_hull)"))
}

#[cold]
fn unbounded(query: &str) -> Failure {
    Failure::unsupported(format_args!("a half-space is unbounded and has no {query}"))
}

/// The shape behind its support mapping.
pub(crate) fn convex_for<'s>(shape: &'s Shape, query: &str) -> Fallible<&'s dyn hullmap::Shape> {
    shape.kind.convex().ok_or_else(|| match &shape.kind {
        Kind::HalfSpace(_) => unbounded(query),
        Kind::Sheet(sheet) => not_for_sheets(sheet, query),
        kind => not_for(kind.name(), query),
    })
}

/// Box around a shape at a pose.
pub(crate) fn bounds(shape: &Shape, pose: Pose) -> Fallible<types::Bounds> {
    let found = match &shape.kind {
        Kind::Compound(pack) => {
            let all = pack.hulls().map(|hull| hullmap::SupportMap::bounds_under(&hull, pose));
            all.reduce(around)
        }
        Kind::Sheet(sheet) => {
            let triangles = (0..sheet.triangle_count()).filter_map(|triangle| sheet.triangle(triangle));
            let all = triangles.map(|triangle| hullmap::SupportMap::bounds_under(&triangle, pose));
            all.reduce(around)
        }
        Kind::HalfSpace(_) => return Err(unbounded("bounds")),
        kind => kind.convex().map(|shape| shape.bounds_under(pose)),
    };
    // Only a pack that was opened without checks has no hulls.
    let found = found.ok_or_else(|| Failure::unsupported("the compound has no hulls"))?;
    Ok(types::Bounds { min: found.min.into(), max: found.max.into() })
}

/// The box around two boxes.
fn around(p: hullmap::Bounds, q: hullmap::Bounds) -> hullmap::Bounds {
    hullmap::Bounds { min: p.min.min(q.min), max: p.max.max(q.max) }
}

/// Where a ray enters a shape.
pub(crate) fn ray(shape: &Shape, ray: &hullmap::Ray, settings: &CastSettings) -> Fallible<types::RayHit> {
    let found = match &shape.kind {
        Kind::HalfSpace(half_space) => half_space.ray(ray, settings),
        Kind::Hull(hull) => hullmap::ray(hull.hull(), ray, settings),
        Kind::Compound(pack) => {
            let CompoundAnswer { answer, hulls, .. } = compound::ray(&Compound::new(pack), ray, settings);
            return Ok(types::RayHit::new(answer, hulls[0]));
        }
        Kind::Sheet(sheet) => {
            let CompoundAnswer { answer, hulls, .. } = compound::ray(sheet, ray, settings);
            return Ok(types::RayHit::new(answer, hulls[0]));
        }
        Kind::Convex(convex) => hullmap::ray(&**convex, ray, settings),
    };
    Ok(types::RayHit::new(found, 0))
}

/// Signed distance of a point.
pub(crate) fn signed_distance(
    shape: &Shape,
    point: DVec3,
    settings: &Settings,
    memory: &mut Memory,
) -> Fallible<types::SignedDistance> {
    let found = match &shape.kind {
        Kind::HalfSpace(half_space) => half_space.signed_distance(point).map(|answer| (answer, 0)),
        Kind::Hull(hull) => {
            hullmap::signed_distance(hull.hull(), point, settings, &mut memory.convex).map(|answer| (answer, 0))
        }
        Kind::Compound(pack) => {
            let found = compound::signed_distance(&Compound::new(pack), point, settings, memory.compound());
            found.map(|CompoundAnswer { answer, hulls, .. }| (answer, hulls[0]))
        }
        Kind::Sheet(sheet) => return Err(not_for_sheets(sheet, "signed distance")),
        Kind::Convex(convex) => {
            hullmap::signed_distance(&**convex, point, settings, &mut memory.convex).map(|answer| (answer, 0))
        }
    };
    let (answer, hull) = found.map_err(|error| Failure::new(types::Result::InvalidArgument, error))?;
    Ok(types::SignedDistance::new(answer, hull))
}

/// Support points in many directions.
pub(crate) fn support(
    shape: &Shape,
    directions: &[types::Vec3],
    out: &mut [MaybeUninit<types::Support>],
) -> Fallible<()> {
    fn each<S>(shape: &S, directions: &[types::Vec3], out: &mut [MaybeUninit<types::Support>])
    where
        S: hullmap::SupportMap + ?Sized,
    {
        for (direction, out) in directions.iter().zip(out) {
            out.write(shape.support_point((*direction).into()).into());
        }
    }
    match &shape.kind {
        Kind::Hull(hull) => each(hull.hull(), directions, out),
        _ => each(convex_for(shape, "support point")?, directions, out),
    }
    Ok(())
}
