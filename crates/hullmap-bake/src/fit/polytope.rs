//! Convex polytopes as lists of faces, cut by planes.

use glam::DVec3;

use crate::hull::polygon;
use hullmap_geometry::planes::{self, HalfSpace};

/// A convex polytope: its faces, each with its corners in order around it, in either direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Polytope {
    faces: Vec<Vec<DVec3>>,
}

impl Polytope {
    /// An axis-aligned box.
    pub fn of_box(low: DVec3, high: DVec3) -> Self {
        let corner = |at: usize| DVec3::from_array([0, 1, 2].map(|axis| [low, high][at >> axis & 1][axis]));
        let quads = [[0, 2, 6, 4], [1, 3, 7, 5], [0, 1, 5, 4], [2, 3, 7, 6], [0, 1, 3, 2], [4, 5, 7, 6]];
        Self { faces: quads.map(|quad| quad.map(corner).to_vec()).to_vec() }
    }

    /// Its corners. Each occurs once for each of its faces.
    pub fn corners(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.faces.iter().flatten().copied()
    }

    /// A point inside: the mean of the faces' corners.
    pub fn middle(&self) -> DVec3 {
        let count = self.corners().count().max(1);
        self.corners().sum::<DVec3>() / count as f64
    }

    /// Volume, by the tetrahedra from the middle.
    pub fn volume(&self) -> f64 {
        self.tetrahedra().map(|[a, b, c, d]| (a - d).cross(b - d).dot(c - d).abs()).sum::<f64>() / 6.0
    }

    /// Tetrahedra that make up the polytope: from the triangles of its faces to the middle.
    pub fn tetrahedra(&self) -> impl Iterator<Item = [DVec3; 4]> + '_ {
        let middle = self.middle();
        self.faces.iter().flat_map(|face| planes::fan(face)).map(move |[a, b, c]| [a, b, c, middle])
    }

    /// Maximum height of its corners above a plane.
    pub fn height(&self, plane: &HalfSpace) -> f64 {
        self.corners().map(|p| plane.height(p)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// The parts inside and outside of a plane. Corners within `tolerance` count as on it.
    pub fn cut(&self, plane: &HalfSpace, tolerance: f64) -> [Option<Self>; 2] {
        if self.height(plane) <= tolerance {
            return [Some(self.clone()), None];
        }
        if self.height(&plane.opposite()) <= tolerance {
            return [None, Some(self.clone())];
        }
        let mut sides = [Vec::with_capacity(self.faces.len() + 1), Vec::with_capacity(self.faces.len() + 1)];
        let mut border = Vec::new();
        for face in &self.faces {
            for (side, polygon) in sides.iter_mut().zip(planes::cut(face, plane, tolerance)) {
                border.extend(polygon.iter().filter(|p| plane.height(**p).abs() <= tolerance));
                side.extend(Some(polygon).filter(|polygon| polygon.len() > 2));
            }
        }
        let outline = polygon::hull(&border, plane.normal);
        let cap: Vec<DVec3> = outline.iter().map(|corner| border[*corner as usize]).collect();
        sides.map(|mut faces| {
            faces.extend(Some(cap.clone()).filter(|cap| cap.len() > 2));
            (faces.len() > 3).then_some(Self { faces })
        })
    }

    /// Polytopes that make up what is outside of at least one of `planes`. Pieces that do not reach
    /// more than `least` above one of them are dropped.
    pub fn beyond(self, planes: &[HalfSpace], least: f64, tolerance: f64) -> Vec<Self> {
        let mut order: Vec<(f64, &HalfSpace)> = planes.iter().map(|plane| (self.height(plane), plane)).collect();
        order.retain(|(height, _)| *height > least);
        // Planes that cut off much come first, so that there are few pieces.
        order.sort_by(|a, b| b.0.total_cmp(&a.0));
        let (mut left, mut outside) = (Some(self), Vec::new());
        for (_, plane) in order {
            let Some(inside) = left.filter(|inside| inside.faces.len() > 3) else { break };
            if inside.height(plane) <= least {
                left = Some(inside);
                continue;
            }
            let [within, beyond] = inside.cut(plane, tolerance);
            outside.extend(beyond);
            left = within;
        }
        outside
    }
}

#[cfg(test)]
mod tests {
    use shapes::rng::SplitMix64;

    use super::*;

    fn random_plane(rng: &mut SplitMix64) -> HalfSpace {
        let mut component = || 2.0 * rng.unit() - 1.0;
        let normal = DVec3::new(component(), component(), component()).normalize_or(DVec3::X);
        HalfSpace { normal, offset: 0.7 * component() }
    }

    #[test]
    fn sides_make_up_the_whole() {
        let mut rng = SplitMix64::new(31);
        let mut cuts = 0;
        for _ in 0..200 {
            let mut pieces = vec![Polytope::of_box(DVec3::splat(-1.0), DVec3::ONE)];
            for _ in 0..6 {
                let plane = random_plane(&mut rng);
                let of = |piece: Polytope| {
                    let sides = piece.cut(&plane, 1e-12);
                    let volume: f64 = sides.iter().flatten().map(Polytope::volume).sum();
                    assert!((volume - piece.volume()).abs() < 1e-9, "{volume} {}", piece.volume());
                    for (side, sign) in sides.iter().zip([-1.0, 1.0]) {
                        assert!(side.iter().all(|side| sign * plane.height(side.middle()) > -1e-12));
                    }
                    sides
                };
                let sides: Vec<_> = pieces.into_iter().map(of).collect();
                cuts += sides.iter().filter(|sides| sides.iter().all(Option::is_some)).count();
                pieces = sides.into_iter().flatten().flatten().collect();
            }
            let volume: f64 = pieces.iter().map(Polytope::volume).sum();
            assert!((volume - 8.0).abs() < 1e-8, "{volume}");
        }
        assert!(cuts > 5_000, "{cuts}");
    }

    #[test]
    fn what_is_beyond_a_box_has_the_rest_of_the_volume() {
        let (low, high) = (DVec3::new(-0.5, -0.25, -0.125), DVec3::new(0.25, 0.5, 0.75));
        let planes = [0, 1, 2].map(|axis| {
            let normal = DVec3::AXES[axis];
            [HalfSpace { normal, offset: high[axis] }, HalfSpace { normal: -normal, offset: -low[axis] }]
        });
        let whole = Polytope::of_box(DVec3::splat(-1.0), DVec3::ONE);
        let rest = whole.clone().beyond(planes.as_flattened(), 0.0, 1e-12);
        let volume: f64 = rest.iter().map(Polytope::volume).sum();
        assert!((volume - (8.0 - (high - low).element_product())).abs() < 1e-12, "{volume}");
        let around = planes.map(|pair| pair.map(|plane| plane.moved(1.0)));
        assert_eq!(whole.beyond(around.as_flattened(), 0.0, 1e-12), []);
    }
}
