//! Polygons of many corners as parry's features, which have at most four.

use hullmap::glam::DVec3;
use hullmap::{Corner, Feature};

use super::convert::narrow;
use super::parry::shape::{PackedFeatureId, PolygonalFeature};

/// Bits that parry leaves for the index of a vertex, edge or face.
const CODE: u32 = 0x3fff_ffff;

/// Writes `feature` with its best four corners: two that are far from each other, and the farthest
/// on either side of the line through them. They span about half of the polygon's area or more.
pub(super) fn write(feature: &Feature, out: &mut PolygonalFeature) {
    *out = PolygonalFeature::default();
    let mut chosen = [0; 4];
    let count = four(feature.corners(), &mut chosen);
    let corner = |slot: usize| chosen.get(slot).and_then(|i| feature.corners().get(*i)).copied().unwrap_or_default();
    out.num_vertices = count;
    for (slot, ((vertex, vid), eid)) in out.vertices.iter_mut().zip(&mut out.vids).zip(&mut out.eids).enumerate() {
        let slot = slot.min(count.saturating_sub(1));
        let (start, end) = (corner(slot), corner(if slot + 1 < count { slot + 1 } else { 0 }));
        *vertex = narrow(start.point);
        *vid = vertex_id(start.vertex);
        *eid = edge_id(start.vertex, end.vertex);
    }
    out.fid = face_id();
}

/// Id of a vertex.
pub(super) fn vertex_id(vertex: u32) -> PackedFeatureId {
    PackedFeatureId::vertex(vertex & CODE)
}

/// Id of the edge between two vertices, the same in both directions. Two edges may share an id, but
/// two edges of one face hardly ever do.
pub(super) fn edge_id(a: u32, b: u32) -> PackedFeatureId {
    let (low, high) = (a.min(b), a.max(b));
    PackedFeatureId::edge((low.wrapping_mul(0x9e37_79b1).rotate_left(13) ^ high) & CODE)
}

/// Id of the face of a feature. A point on a face is identified by the other shape's vertex.
pub(super) fn face_id() -> PackedFeatureId {
    PackedFeatureId::face(0)
}

/// Indices of the best four corners of a polygon, in its order. Returns their number, which is
/// below four if the polygon has fewer corners, or all corners are on one side of the line.
fn four(corners: &[Corner], chosen: &mut [usize; 4]) -> usize {
    if corners.len() <= 4 {
        *chosen = [0, 1, 2, 3];
        return corners.len();
    }
    let at = |i: usize| corners.get(i).map_or(DVec3::ZERO, |corner| corner.point);
    let greatest = |measure: &dyn Fn(DVec3) -> f64| {
        let mut best = (f64::NEG_INFINITY, 0);
        for (i, corner) in corners.iter().enumerate() {
            let found = measure(corner.point);
            if found > best.0 {
                best = (found, i);
            }
        }
        best
    };
    let (_, first) = greatest(&|p| p.distance_squared(at(0)));
    let (_, second) = greatest(&|p| p.distance_squared(at(first)));
    // Normal of the polygon by Newell's sum, and the direction across the line.
    let mut normal = DVec3::ZERO;
    for (i, corner) in corners.iter().enumerate() {
        let next = at(if i + 1 < corners.len() { i + 1 } else { 0 });
        normal += (corner.point - at(first)).cross(next - at(first));
    }
    let across = normal.cross(at(second) - at(first));
    let (left, third) = greatest(&|p| (p - at(first)).dot(across));
    let (right, fourth) = greatest(&|p| -(p - at(first)).dot(across));
    let mut found = [Some(first), Some(second), (left > 0.0).then_some(third), (right > 0.0).then_some(fourth)];
    found.sort_unstable();
    let mut count = 0;
    for (i, slot) in found.into_iter().flatten().zip(chosen.iter_mut()) {
        *slot = i;
        count += 1;
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disc(n: usize) -> Feature {
        let mut feature = Feature::new();
        for i in 0..n {
            let angle = i as f64 / n as f64 * std::f64::consts::TAU;
            let point = DVec3::new(angle.cos(), angle.sin(), 1.0);
            feature.push(Corner { point, vertex: i as u32 });
        }
        feature
    }

    #[test]
    fn a_disc_becomes_a_square() {
        for n in [8, 12, 32] {
            let mut out = PolygonalFeature::default();
            write(&disc(n), &mut out);
            assert_eq!(out.num_vertices, 4);
            let [a, b, c, d] = out.vertices;
            let area = 0.5 * ((c - a).cross(d - b)).length();
            assert!(area > 1.9, "{n}: {area}");
        }
    }

    #[test]
    fn few_corners_stay_as_they_are() {
        for n in 1..=4 {
            let mut out = PolygonalFeature::default();
            write(&disc(n), &mut out);
            assert_eq!(out.num_vertices, n);
            for (i, vertex) in out.vertices[..n].iter().enumerate() {
                assert_eq!(*vertex, narrow(disc(n).corners()[i].point));
                assert_eq!(out.vids[i], vertex_id(i as u32));
            }
        }
    }

    #[test]
    fn edges_have_one_id_in_both_directions() {
        assert_eq!(edge_id(3, 7), edge_id(7, 3));
        assert_ne!(edge_id(3, 7), edge_id(3, 8));
    }
}
