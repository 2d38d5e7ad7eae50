//! Final hulls of the parts that were found, which together contain the whole surface. If a mirror
//! halves the mesh, each hull is made with its image.

use rayon::prelude::*;

use super::{
    part::{BUILDS, SourceVertices},
    partition::{
        Halves, Part,
        body::Body,
        few,
        field::Field,
        shape::{large_faces, tightened},
        surface::Surface,
        symmetric,
        wrap::{self, HullLimits},
    },
    rest,
};
use crate::{fit::uncovered_triangles, hull::Hull, symmetry::Mirror};
use hullmap_geometry::{PointSet, planes::HalfSpace, triangle::Triangle};

/// Distance from the parts up to which the surface counts as covered, relative to the diagonal.
pub const COVERED: f64 = 1e-7;

/// Maximum number of rounds for triangles that are not proven to be covered, for instance because
/// they have no area. A part that cuts a triangle may raise its bound, so rounds repeat.
const UNCOVERED_ROUNDS: usize = 4;

/// Numbers of vertices with which a symmetric hull is tried, relative to the maximum: the half of a
/// hull and its image have other corners than the hull.
const SYMMETRIC_VERTICES: [f64; 4] = [1.0, 0.8, 0.6, 0.45];

/// A final hull, and its mirror image if that is another part.
struct Unit {
    hull: Hull,
    image: Option<Hull>,
}

/// Makes final hulls.
pub struct Finish<'a> {
    pub mesh: &'a PointSet,
    pub vertices: &'a SourceVertices<'a>,
    pub field: &'a Field<'a>,
    pub surface: &'a Surface,
    pub bounds: HullLimits<'a>,
    pub max_parts: Option<u32>,
}

impl Unit {
    fn hulls(&self) -> impl Iterator<Item = &Hull> {
        std::iter::once(&self.hull).chain(&self.image)
    }
}

impl Finish<'_> {
    /// The hulls of parts, and of what they do not cover; at most as many as are allowed. They
    /// cover the mesh, as far as [`UNCOVERED_ROUNDS`] can prove it; `fit/fits.rs` measures what is
    /// left. The hulls of a symmetric mesh are symmetric as far as that can be proven.
    pub fn hulls(&self, Halves { whole, mirrored }: Halves) -> Vec<Hull> {
        let Self { mesh, bounds, max_parts, .. } = *self;
        let sides: Vec<HalfSpace> = large_faces(&Body::new(&mesh.points(), 0.0)).collect();
        let mut units: Vec<Unit> = whole.par_iter().map(|part| self.whole(part, &sides)).collect();
        units.par_extend(mirrored.par_iter().map(|part| self.mirrored(part, &sides)));
        for _ in 0..UNCOVERED_ROUNDS {
            let hulls: Vec<&Hull> = units.iter().flat_map(Unit::hulls).collect();
            let missing = uncovered_triangles(mesh, &hulls, COVERED * bounds.diagonal, bounds.deadline);
            if missing.is_empty() {
                break;
            }
            let missing: Vec<Triangle> = missing.into_iter().map(|t| mesh.corners(&mesh.triangles[t])).collect();
            self.add_rest(&mut units, &missing, max_parts.map_or(usize::MAX, |most| most as usize));
        }
        units.into_iter().flat_map(|unit| [Some(unit.hull), unit.image]).flatten().collect()
    }

    fn mirror(&self) -> Option<&Mirror> {
        self.surface.mirrors.first()
    }

    fn tight(&self, part: &Part, sides: &[HalfSpace], share: f64) -> Hull {
        let max_vertices = ((share * self.bounds.max_vertices as f64) as usize).max(crate::simplify::MIN_VERTICES);
        let bounds = HullLimits { max_vertices, ..self.bounds };
        let tight = tightened(self.field, part, sides, &bounds);
        wrap::thick(self.field, tight, &self.bounds)
    }

    /// The hull of a part without an image. It is its own image if there is a mirror.
    fn whole(&self, part: &Part, sides: &[HalfSpace]) -> Unit {
        let tight = self.tight(part, sides, 1.0);
        let symmetric = self.mirror().and_then(|mirror| {
            let of = |hull: &Hull| symmetric::symmetric(self.field, hull, mirror, &self.bounds);
            let first = of(&tight);
            first.or_else(|| SYMMETRIC_VERTICES[1..].iter().find_map(|share| of(&self.tight(part, sides, *share))))
        });
        Unit { hull: self.vertices.built(symmetric.unwrap_or(tight)), image: None }
    }

    fn mirrored(&self, part: &Part, sides: &[HalfSpace]) -> Unit {
        let hull = self.tight(part, sides, 1.0);
        let Some(mirror) = self.mirror() else { return Unit { hull: self.vertices.built(hull), image: None } };
        let grown = symmetric::grown(&hull, mirror, self.bounds.diagonal);
        self.with_image(grown.unwrap_or(hull), mirror)
    }

    fn with_image(&self, hull: Hull, mirror: &Mirror) -> Unit {
        let image_of = |hull: &Hull| symmetric::image(hull, mirror).map(|image| self.vertices.built(image));
        let mut hull = self.vertices.built(hull);
        for _ in 0..BUILDS {
            let Some(image) = image_of(&hull) else { break };
            if image.vertices.len() == hull.vertices.len() {
                return Unit { hull, image: Some(image) };
            }
            let Some(fewer) = image_of(&image) else { break };
            hull = fewer;
        }
        Unit { image: image_of(&hull), hull }
    }

    /// A part of a triangle that no other covers, and its image if that is another part and there
    /// is `room`.
    fn of_triangle(&self, corners: &Triangle, room: usize) -> Vec<Unit> {
        let HullLimits { diagonal, max_vertices, .. } = self.bounds;
        let own = wrap::of_polygon(corners, diagonal, self.bounds.thickness, max_vertices);
        let unit = |(_, hull)| match self.mirror() {
            Some(mirror) if room > 1 => self.with_image(hull, mirror),
            _ => Unit { hull: self.vertices.built(hull), image: None },
        };
        own.into_iter().map(unit).collect()
    }

    /// Adds uncovered triangles to the nearest parts if that is proven, and as parts otherwise. At
    /// `max_parts`, or after the deadline, parts protrude more.
    fn add_rest(&self, units: &mut Vec<Unit>, triangles: &[Triangle], max_parts: usize) {
        let all = units.iter().enumerate();
        let owners: Vec<(usize, usize)> =
            all.flat_map(|(index, unit)| (0..unit.hulls().count()).map(move |side| (index, side))).collect();
        let (mut count, mut added) = (owners.len(), Vec::<Body>::new());
        let of_parts = rest::by_part(&units.iter().flat_map(Unit::hulls).collect::<Vec<_>>(), triangles);
        for (part, triangles) in of_parts {
            let owner = owners.get(part).copied();
            let absorb = |units: &mut [Unit], some: &[Triangle], must: bool| {
                let grown =
                    owner.and_then(|(index, side)| Some((index, self.absorbed(&units[index], side, some, must)?)));
                let is_absorbed = grown.is_some();
                grown.into_iter().for_each(|(index, unit)| units[index] = unit);
                is_absorbed
            };
            let is_over = || self.bounds.is_over();
            let left = rest::in_halves(&triangles, is_over, |some| absorb(units, some, false));
            let mut must = Vec::new();
            for corners in left {
                let slack = COVERED * self.bounds.diagonal;
                if added.iter().any(|body| corners.iter().all(|p| body.holds(*p, slack))) {
                } else if count < max_parts && (owner.is_none() || !is_over()) {
                    let own = self.of_triangle(&corners, max_parts - count);
                    let hulls: Vec<&Hull> = own.iter().flat_map(Unit::hulls).collect();
                    count += hulls.len();
                    added.extend(hulls.iter().map(|hull| Body::new(&hull.positions(), 0.0)));
                    units.extend(own);
                } else {
                    must.push(corners);
                }
            }
            if !must.is_empty() {
                absorb(units, &must, true);
            }
        }
    }

    /// A unit whose hull on one `side` has absorbed triangles; `None` if the hull is not proven to
    /// be within the limit. If it `must` absorb them, a larger protrusion is accepted.
    fn absorbed(&self, unit: &Unit, side: usize, triangles: &[Triangle], must: bool) -> Option<Unit> {
        let HullLimits { diagonal, thickness, max_vertices, .. } = self.bounds;
        let hull = unit.hulls().nth(side)?;
        let mut points = [hull.positions().as_slice(), triangles.as_flattened()].concat();
        let own_image = self.mirror().filter(|_| unit.image.is_none());
        if let Some(mirror) = own_image {
            points.extend(points.clone().into_iter().map(|p| mirror.image(p)));
        }
        let grown = few::within_vertices(wrap::tight(&points, diagonal, thickness)?, max_vertices);
        let grown = own_image
            .and_then(|mirror| symmetric::symmetric(self.field, &grown, mirror, &self.bounds))
            .unwrap_or(grown);
        let is_proven = |hull: &Hull| wrap::prove(self.field, hull, &self.bounds, wrap::MEASUREMENTS).is_ok();
        if !must && !is_proven(&grown) {
            return None;
        }
        match (self.mirror(), side, &unit.image) {
            (Some(mirror), 0, Some(_)) => Some(self.with_image(grown, mirror)),
            (Some(mirror), _, Some(_)) => {
                let Unit { hull, image } = self.with_image(grown, mirror);
                Some(Unit { hull: image?, image: Some(hull) })
            }
            _ => Some(Unit { hull: self.vertices.built(grown), image: None }),
        }
    }
}
