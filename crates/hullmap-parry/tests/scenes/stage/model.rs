//! Bodies of the scenes: a baked hull, or convex parts, and parry's hulls of the same points.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use hullmap::{Pack, SharedHull};
use hullmap_import::{ImportOptions, Limits, import, read};
use hullmap_parry::{BakedHull, union};
use hullmap_testkit::packs;
use rapier3d::prelude::*;

use super::way::Way;

/// A convex body, or one of convex parts.
#[derive(Clone)]
pub struct Model {
    /// Name for messages.
    pub name: String,
    /// The baked hull; for a body of parts, the hull of all of them.
    pub hull: SharedHull,
    /// The baked hulls of the parts; for a convex body, its only hull.
    pub parts: Vec<SharedHull>,
    parry: SharedShape,
}

impl Model {
    /// The hull of `points`, which are moved and scaled: the centre of their box becomes the
    /// origin, and its longest side `size`. `None` if the hull is flat. Panics if the points cannot
    /// be baked, or parry rejects them.
    pub fn sized(name: &str, points: &[[f32; 3]], size: f32) -> Option<Self> {
        let moved: Vec<[f32; 3]> = points.iter().map(centred(points, size)).collect();
        Self::new(name, &moved)
    }

    /// The hull of `points` as they are. `None` if it is flat. Panics if the points cannot be
    /// baked, or parry rejects them.
    pub fn new(name: &str, points: &[[f32; 3]]) -> Option<Self> {
        let pack: Arc<Pack> = Arc::new(packs::tree_pack(points));
        let hull = pack.shared_hull(0).expect("one hull");
        if hull.hull().rank() < 3 {
            return None;
        }
        // parry's algorithm may panic on all points of a detailed mesh, so it gets the vertices.
        let vertices: Vec<Vector> = hull.hull().vertices().collect();
        let parry = SharedShape::convex_hull(&vertices)
            .or_else(|| Some(SharedShape::new(BakedHull::new(hull.clone()).to_convex_polyhedron()?)))
            .expect("parry takes the hull");
        Some(Self { name: name.to_owned(), parts: vec![hull.clone()], hull, parry })
    }

    /// The shape for a way of using hulls.
    pub fn shape(&self, way: Way) -> SharedShape {
        match way {
            Way::Parry => self.parry.clone(),
            Way::Shapes | Way::Dispatcher => {
                union(self.parts.iter().cloned().map(BakedHull::new)).expect("a body has parts")
            }
        }
    }

    /// Distance of the lowest point of the body below its frame's origin, at a rotation.
    pub fn depth_below_origin(&self, rotation: Rotation) -> f32 {
        self.extent(Pose::from_parts(Vector::ZERO, rotation), -Vector::Y)
    }

    /// Distance of the farthest point from the origin.
    pub fn radius(&self) -> f32 {
        self.hull.hull().vertices().map(Vector::length).fold(0.0, f32::max)
    }

    /// How far the body at `pose` reaches in direction `dir`, from the world's origin.
    pub fn extent(&self, pose: Pose, dir: Vector) -> f32 {
        (pose * self.hull.hull().support(pose.rotation.inverse() * dir).point).dot(dir)
    }
}

/// Moves the centre of the box around points to the origin, and scales its longest side to `size`.
fn centred(points: &[[f32; 3]], size: f32) -> impl Fn(&[f32; 3]) -> [f32; 3] {
    let bound = |k: usize, pick: fn(f32, f32) -> f32| points.iter().map(|p| p[k]).reduce(pick).unwrap_or(0.0);
    let (low, high) = ([0, 1, 2].map(|k| bound(k, f32::min)), [0, 1, 2].map(|k| bound(k, f32::max)));
    let factor = size / (0..3).map(|k| high[k] - low[k]).fold(0.0, f32::max);
    move |p| [0, 1, 2].map(|k| (p[k] - 0.5 * (low[k] + high[k])) * factor)
}

/// The hulls of all solid meshes in a folder of OBJ and STL files, each with `size` as the longest
/// side of its box. Sorted by name. Panics if a file cannot be read or imported.
pub fn meshes(folder: &Path, size: f32) -> Vec<Model> {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.expect("a folder entry").path()).collect();
    files.retain(|path| path.extension().is_some_and(|own| own == "obj" || own == "stl"));
    files.sort();
    files.iter().filter_map(|path| mesh(path, size)).collect()
}

/// The hull of one mesh file; `None` if it is flat. Panics if the file cannot be read or imported.
pub fn mesh(path: &Path, size: f32) -> Option<Model> {
    let name = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or("mesh");
    let (file, limits) = (path.display().to_string(), Limits::DEFAULT);
    let source = read(&file, path, &limits).unwrap_or_else(|error| panic!("{file}: {error:?}"));
    let imported = import(&file, name, path, &source, &ImportOptions::DEFAULT, &limits);
    let sets = imported.unwrap_or_else(|error| panic!("{error}")).point_sets;
    Model::sized(name, &sets.into_iter().flat_map(|set| set.positions).collect::<Vec<_>>(), size)
}

/// Bodies that need no file: generated families of many kinds.
pub fn generated(size: f32) -> Vec<Model> {
    use shapes::families::{cone, cube_grid, lens, prism, rock, rotated_prism, sphere};
    let families = [
        ("rock_40", rock(40, 1)),
        ("rock_600", rock(600, 2)),
        ("prism_64", prism(64, 1)),
        ("rotated_prism", rotated_prism(300, 1)),
        ("cone", cone(200, 1)),
        ("lens", lens(400, 1)),
        ("sphere", sphere(1000, 1)),
        ("cube", cube_grid(27, 1)),
    ];
    families.iter().filter_map(|(name, points)| Model::sized(name, points, size)).collect()
}

/// An upright prism of `sides` sides along y, with the circle around its sides of radius `radius`.
/// Panics if it cannot be baked.
pub fn prism(sides: usize, radius: f32, half_height: f32) -> Model {
    let mut points = Vec::new();
    for i in 0..sides {
        let angle = i as f64 / sides as f64 * std::f64::consts::TAU;
        let (x, z) = ((angle.cos() as f32) * radius, (angle.sin() as f32) * radius);
        points.extend([[x, -half_height, z], [x, half_height, z]]);
    }
    Model::new(&format!("prism_{sides}"), &points).expect("a solid")
}
