//! Polygons of many corners as parry's features, which have at most four.

use hullmap::glam::{DVec2, DVec3};
use hullmap::manifold::select::{Choice, Spot, choose};
use hullmap::shapes::{MAX_CORNERS, TILT, tilted};
use hullmap::{Corner, Feature, SupportMap as _};

use super::BakedHull;
use super::convert::narrow;
use super::parry::shape::{PackedFeatureId, PolygonalFeature};

/// Fraction of the outer radius up to which heights are equal. Among 696 bodies, 650 sleep after 10
/// s. With twice the fraction, 654 sleep, but 3 gain energy; with a tenth of it, 641 sleep.
const SLIGHT: f64 = 2e-3;

/// Prediction of Rapier, for a length unit of 1 m. parry does not pass on the real one. It decides
/// how far out vertices are considered if a body tips.
const PREDICTION: f64 = 0.02;

/// Bits that parry leaves for the index of a vertex, edge or face.
const CODE: u32 = 0x3fff_ffff;

pub(super) struct Outline<'h> {
    hull: &'h BakedHull,
    /// The direction, of unit length.
    normal: DVec3,
    axes: [DVec3; 2],
}

impl<'h> Outline<'h> {
    /// The side that faces `dir`, in the hull's frame.
    pub(super) fn new(hull: &'h BakedHull, dir: DVec3) -> Self {
        let normal = dir.normalize_or(DVec3::X);
        let side = normal.any_orthonormal_vector();
        Self { hull, normal, axes: [side, normal.cross(side)] }
    }

    fn projected(&self, point: DVec3) -> DVec2 {
        let [x, y] = self.axes;
        DVec2::new(point.dot(x), point.dot(y))
    }

    fn spots(&self, feature: &Feature) -> [Spot; MAX_CORNERS] {
        let mut spots = [Spot::default(); MAX_CORNERS];
        for (spot, corner) in spots.iter_mut().zip(feature.corners()) {
            *spot = Spot { at: self.projected(corner.point), depth: corner.point.dot(self.normal) };
        }
        spots
    }

    fn center(&self) -> DVec2 {
        self.projected(self.hull.interior_point())
    }

    pub(super) fn four(&self, feature: &Feature) -> Choice {
        let (spots, slight) = (self.spots(feature), SLIGHT * self.hull.outer_radius());
        choose(spots.get(..feature.corners().len()).unwrap_or_default(), self.center(), slight, None)
    }

    pub(super) fn is_stable(&self, feature: &Feature, four: &Choice) -> bool {
        four.is_below(&self.spots(feature), self.center())
    }

    pub(super) fn widen(&self, feature: &mut Feature) {
        #[expect(clippy::manual_clamp, reason = "NaN becomes the lower end")]
        let tilt = (PREDICTION / self.hull.outer_radius()).max(TILT).min(1.0);
        for support in tilted(self.hull, self.normal, tilt) {
            if feature.corners().iter().all(|corner| corner.vertex != support.feature) {
                feature.push(Corner { point: support.point, vertex: support.feature });
            }
        }
    }

    /// Writes the chosen corners of `feature`, in order around it.
    pub(super) fn write(&self, feature: &Feature, four: &Choice, out: &mut PolygonalFeature) {
        *out = PolygonalFeature::default();
        let mut chosen = [Corner::default(); 4];
        let mut count = 0;
        for (place, index) in chosen.iter_mut().zip(four.indices()) {
            *place = feature.corners().get(*index).copied().unwrap_or_default();
            count += 1;
        }
        let chosen = chosen.get_mut(..count).unwrap_or_default();
        let middle = chosen.iter().map(|corner| corner.point).sum::<DVec3>() / count.max(1) as f64;
        let angle = |corner: &Corner| self.projected(corner.point - middle).to_angle();
        chosen.sort_by(|p, q| angle(p).total_cmp(&angle(q)));
        let corner = |place: usize| chosen.get(place).copied().unwrap_or_default();
        out.num_vertices = count;
        for (place, ((vertex, vid), eid)) in out.vertices.iter_mut().zip(&mut out.vids).zip(&mut out.eids).enumerate() {
            let place = place.min(count.saturating_sub(1));
            let (start, end) = (corner(place), corner(if place + 1 < count { place + 1 } else { 0 }));
            *vertex = narrow(start.point);
            *vid = vertex_id(start.vertex);
            *eid = edge_id(start.vertex, end.vertex);
        }
        out.fid = face_id();
    }
}

pub(super) fn vertex_id(vertex: u32) -> PackedFeatureId {
    PackedFeatureId::vertex(vertex & CODE)
}

/// Equal for both directions. Two edges may share an id, but two edges of one face rarely do.
pub(super) fn edge_id(a: u32, b: u32) -> PackedFeatureId {
    let (low, high) = (a.min(b), a.max(b));
    PackedFeatureId::edge((low.wrapping_mul(0x9e37_79b1).rotate_left(13) ^ high) & CODE)
}

/// Id of the face of a feature. A point on a face is identified by the other shape's vertex.
pub(super) fn face_id() -> PackedFeatureId {
    PackedFeatureId::face(0)
}

#[cfg(test)]
mod tests {
    use super::super::convert::wide;
    use super::super::parry::shape::PolygonalFeatureMap;
    use super::*;

    fn cap(n: usize) -> (BakedHull, PolygonalFeature) {
        let corner = |i: usize, z: f32| {
            let angle = (i as f64 / n as f64 * std::f64::consts::TAU) as f32;
            [angle.cos(), angle.sin(), z]
        };
        let points: Vec<[f32; 3]> = (0..n).flat_map(|i| [corner(i, 0.0), corner(i, 1.0)]).collect();
        let pack = std::sync::Arc::new(hullmap_testkit::packs::tree_pack(&points));
        let hull = BakedHull::new(pack.shared_hull(0).unwrap());
        let mut out = PolygonalFeature::default();
        hull.local_support_feature(narrow(DVec3::Z), &mut out);
        (hull, out)
    }

    #[test]
    fn a_disc_becomes_a_square() {
        for n in [8, 12, 32, 64] {
            let (_, out) = cap(n);
            assert_eq!(out.num_vertices, 4);
            let [a, b, c, d] = out.vertices;
            let area = 0.5 * ((c - a).cross(d - b)).length();
            assert!(area > 1.9, "{n}: {area}");
        }
    }

    #[test]
    fn few_corners_stay_as_they_are() {
        for n in [3, 4] {
            let (hull, out) = cap(n);
            assert_eq!(out.num_vertices, n);
            for (vertex, vid) in out.vertices.iter().zip(out.vids).take(n) {
                let index = (0..).find(|index| hull.hull().vertex(*index).unwrap() == wide(*vertex).as_vec3());
                assert_eq!(vid, vertex_id(index.unwrap()));
                assert_eq!(wide(*vertex).z, 1.0);
            }
        }
    }

    #[test]
    fn edges_have_one_id_in_both_directions() {
        assert_eq!(edge_id(3, 7), edge_id(7, 3));
        assert_ne!(edge_id(3, 7), edge_id(3, 8));
    }
}
