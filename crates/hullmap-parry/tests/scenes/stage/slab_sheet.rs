//! The slab of the slides as triangle meshes and height fields, whole or as two that meet.

use hullmap::glam::Quat;
use hullmap::height_field::Diagonal;
use hullmap_parry::{BakedHull, BakedSurface};
use hullmap_random::SplitMix64;
use hullmap_testkit::packs::tree_pack;
use rapier3d::prelude::*;

use super::sheets::{self, Heights};
use super::slab::{Cut, HALF, THICKNESS};
use super::way::Way;

/// Distance from a side of the slab up to which a triangle is on it: gaps and steps are less.
const OUTSIDE: f32 = 1e-5;

/// Form of the slab.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Convex parts.
    Hulls,
    /// One triangle mesh: the outside of a slab of these parts.
    Mesh,
    /// [`Mesh`](Self::Mesh) with the walls between the parts, which are inside the slab.
    Walls,
    /// One height field, of cells that differ from cut to cut.
    Field,
    /// Two meshes that meet.
    Meshes,
    /// Two fields that meet.
    Fields,
    /// A mesh and a field that meet.
    MeshAndField,
    /// A field and a mesh that meet.
    FieldAndMesh,
}

impl Form {
    /// All forms, in the order of the table.
    pub const ALL: [Self; 8] = [
        Self::Hulls,
        Self::Mesh,
        Self::Walls,
        Self::Field,
        Self::Meshes,
        Self::Fields,
        Self::MeshAndField,
        Self::FieldAndMesh,
    ];
}

/// The slab as a surface, or two, turned by `slope`. Panics for [`Form::Hulls`], and if a part
/// cannot be baked.
pub fn surface(form: Form, cut: Cut, slope: Quat) -> BakedSurface {
    let at = Pose::from_parts(Vector::ZERO, slope);
    let fields = |ends: [f64; 2]| (at, field(cut, ends).surface());
    // The same triangles as a mesh, so that its border is straight.
    let straight = |ends: [f64; 2]| {
        let (vertices, corners) = field(cut, ends).surface().to_trimesh();
        let positions: Vec<[f32; 3]> = vertices.iter().map(|v| (slope * *v).to_array()).collect();
        (Pose::IDENTITY, sheets::mesh(&positions, &corners))
    };
    let (left, right) = ([-HALF, 0.0], [0.0, HALF]);
    let tiles = match form {
        Form::Hulls => panic!("hulls are no surface"),
        Form::Mesh => vec![(Pose::IDENTITY, mesh(cut, slope, |_| true, is_outside))],
        Form::Walls => vec![(Pose::IDENTITY, mesh(cut, slope, |_| true, |_| true))],
        Form::Field => vec![fields([-HALF, HALF])],
        Form::Meshes => {
            let half = |is_left: bool| mesh(cut, slope, move |x| (x < 0.0) == is_left, is_outside);
            [true, false].map(|is_left| (Pose::IDENTITY, half(is_left))).to_vec()
        }
        Form::Fields => vec![fields(left), fields(right)],
        Form::MeshAndField => vec![straight(left), fields(right)],
        Form::FieldAndMesh => vec![fields(left), straight(right)],
    };
    BakedSurface::joined(tiles).expect("a tile")
}

/// The colliders of the slab for a way of using shapes. parry has no tiles that meet: with its own
/// shapes, each is a collider.
pub fn colliders(form: Form, cut: Cut, slope: Quat, way: Way) -> Vec<SharedShape> {
    let surface = surface(form, cut, slope);
    if way != Way::Parry {
        return vec![surface.into()];
    }
    let alone = |tile: &hullmap_parry::SurfaceTile| {
        let at = tile.place();
        let pose = Pose::from_parts(at.translation().as_vec3(), at.rotation().as_quat());
        let own = BakedSurface::new(tile.sheet().clone());
        sheets::shape(&BakedSurface::joined([(pose, own)]).expect("one tile"), way)
    };
    surface.tiles().iter().map(alone).collect()
}

/// Whether a triangle is on the outside of the slab, before the slab is turned.
fn is_outside(corners: [Vector; 3]) -> bool {
    let sides = [(Vector::X, HALF), (-Vector::X, HALF), (Vector::Z, HALF), (-Vector::Z, HALF), (Vector::Y, 0.0)];
    let bottom = (-Vector::Y, THICKNESS);
    let near = |dir: Vector, reach: f64| corners.iter().all(|corner| (corner.dot(dir) - reach as f32).abs() < OUTSIDE);
    sides.into_iter().chain([bottom]).any(|(dir, reach)| near(dir, reach))
}

/// Triangles of the parts whose x `takes` accepts, turned by `slope`. `shows` decides which
/// triangles are included.
fn mesh(cut: Cut, slope: Quat, takes: impl Fn(f64) -> bool, shows: impl Fn([Vector; 3]) -> bool) -> BakedSurface {
    let (mut positions, mut corners) = (Vec::new(), Vec::new());
    for part in cut.parts() {
        if !takes(part.iter().map(|p| p.x).sum::<f64>()) {
            continue;
        }
        let points: Vec<[f32; 3]> = part.iter().map(|p| (slope.as_dquat() * *p).as_vec3().to_array()).collect();
        let pack = std::sync::Arc::new(tree_pack(&points));
        let (vertices, triangles) = BakedHull::new(pack.shared_hull(0).expect("one hull")).to_trimesh();
        let first = positions.len() as u32;
        positions.extend(vertices.iter().map(|v| v.to_array()));
        let flat = |t: &&[u32; 3]| shows(t.map(|corner| slope.inverse() * vertices[corner as usize]));
        corners.extend(triangles.iter().filter(flat).map(|t| t.map(|corner| first + corner)));
    }
    sheets::mesh(&positions, &corners)
}

/// The top of the slab between two x as a field with z up. Each cut has other cells: 8 × 8, with
/// both diagonals, narrow ones, and heights that differ by up to 1 µm. Where the parts of the cut
/// have a gap of 1 µm, or overlap by a cell of 0.2 m, two fields do, too.
fn field(cut: Cut, [start, end]: [f64; 2]) -> Heights {
    let mut rng = SplitMix64::new(17);
    let (spacing, diagonal) = match cut {
        Cut::Whole | Cut::Grid => ([1.0, 1.0], Diagonal::Rising),
        Cut::Random => ([4.0 / 11.0, 8.0 / 17.0], Diagonal::Falling),
        Cut::Gaps => ([0.125, 0.25], Diagonal::Rising),
        Cut::Steps => ([0.25, 0.5], Diagonal::Falling),
        Cut::Overlap => ([0.2, 1.0], Diagonal::Falling),
    };
    let (mut start, mut end) = (start, end);
    if cut == Cut::Overlap {
        (start, end) = ((start - 0.2).max(-HALF), (end + 0.2).min(HALF));
    }
    let gap = if cut == Cut::Gaps { 0.5e-6 } else { 0.0 };
    let cells = [(end - start) / spacing[0], 2.0 * HALF / spacing[1]].map(|count| count.round() as usize);
    let origin = [if start < 0.0 { start - gap } else { start + gap }, -HALF];
    Heights::new(cells, origin, spacing, diagonal, |_, _| {
        if cut == Cut::Steps { rng.between(-1e-6, 1e-6) as f32 } else { 0.0 }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use hullmap::glam::DVec3;

    #[test]
    fn all_forms_cover_the_top_of_the_slab() {
        for form in Form::ALL.into_iter().filter(|form| *form != Form::Hulls) {
            for cut in Cut::CUTS {
                let surface = surface(form, cut, Quat::IDENTITY);
                for i in 0..400 {
                    let place = DVec3::new(f64::from(i % 20) * 0.39 - 3.7, 1.0, f64::from(i / 20) * 0.39 - 3.71);
                    let ray = Ray::new(place.as_vec3(), -Vector::Y);
                    let hit = surface.cast_local_ray(&ray, 5.0, true).unwrap();
                    assert!((hit - 1.0).abs() < 3e-6, "{form:?} {cut:?} {place}: {hit}");
                }
            }
        }
    }
}
