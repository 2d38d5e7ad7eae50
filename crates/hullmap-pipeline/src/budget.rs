//! Budgets: what physics engines accept of one hull, and whether a hull is within it.
//!
//! A limit on faces or edges is met by hulls of few vertices: a hull of V vertices has at most 2V −
//! 4 triangles and 3V − 6 edges (Euler), and a face at most V − 1 corners.
//! [`Budget::sure_vertices`] is the largest V for which every hull fits.

use glam::DVec3;

/// Limits of an engine on one hull. `None`: it has none, or none is known.
#[derive(Debug)]
pub struct Budget {
    pub name: &'static str,
    vertices: usize,
    faces: Option<usize>,
    /// Maximum number of triangles, of which a polygon of n corners has n − 2.
    triangles: Option<usize>,
    edges: Option<usize>,
    face_vertices: Option<usize>,
    aspect: Option<f64>,
    /// Minimum thickness in metres.
    thickness: Option<f64>,
    /// Whether a flat hull is a shape of the engine.
    pub takes_flat: bool,
    /// Consequence of exceeding the limits, for messages.
    otherwise: &'static str,
    pub source: &'static str,
}

const ANY: Budget = Budget {
    name: "",
    vertices: usize::MAX,
    faces: None,
    triangles: None,
    edges: None,
    face_vertices: None,
    aspect: None,
    thickness: None,
    takes_flat: false,
    otherwise: "",
    source: "",
};

/// Every engine. `tests` compares the names with [`NAMES`].
pub static BUDGETS: [Budget; 8] = [
    Budget {
        name: "physx",
        vertices: 255,
        faces: Some(255),
        otherwise: "PhysX computes another hull, or none",
        source: "PhysX 5: PxConvexMeshDesc.h, vertexLimit and polygonLimit; GuCookingConvexMesh.cpp, cookConvexMesh",
        ..ANY
    },
    Budget {
        name: "physx-gpu",
        vertices: 64,
        faces: Some(64),
        face_vertices: Some(32),
        // 100 by the code, for the box and the ball inside a hull; users meet the error from 64 on.
        aspect: Some(64.0),
        otherwise: "PhysX computes another hull, or collides on the processor",
        source: "PhysX 5: GuConvexMesh.cpp, isGpuCompatible; GuConvexMeshData.h, checkExtentRadiusRatio; ManiSkill#1152 for 64:1",
        ..ANY
    },
    Budget {
        name: "jolt",
        vertices: 256,
        thickness: Some(1e-3),
        takes_flat: true,
        otherwise: "Jolt drops vertices",
        source: "Jolt: ConvexHullShape.h, cMaxPointsInHull and mHullTolerance",
        ..ANY
    },
    Budget {
        name: "box3d",
        vertices: 128,
        faces: Some(128),
        edges: Some(128),
        thickness: Some(5e-3),
        otherwise: "box3d rejects the hull",
        source: "box3d: constants.h, B3_MAX_HULL_VERTICES, B3_MAX_HULL_FACES, B3_MAX_HULL_EDGES (full edges), B3_LINEAR_SLOP",
        ..ANY
    },
    Budget {
        name: "unity",
        vertices: 255,
        triangles: Some(255),
        otherwise: "Unity computes another hull",
        source: "Unity Manual, Mesh Collider, Convex: 255 triangles; simple_collider#666: 255 vertices",
        ..ANY
    },
    Budget {
        name: "unreal",
        vertices: 32,
        otherwise: "Unreal may simplify the hull when it is imported",
        source: "simple_collider#666: 8 to 32 vertices are advised; the engine has no fixed limit",
        ..ANY
    },
    Budget {
        name: "newton",
        vertices: 64,
        otherwise: "Newton computes another hull",
        source: "Newton: newton.Mesh, maxhullvert, 64 by default; newton#299",
        ..ANY
    },
    Budget {
        name: "mujoco-warp",
        vertices: 64,
        otherwise: "collisions take twice as long",
        source: "mujoco_warp#1565: 64 vertices are advised; the engine has no limit",
        ..ANY
    },
];

pub const NAMES: [&str; 9] =
    ["none", "physx", "physx-gpu", "jolt", "box3d", "unity", "unreal", "newton", "mujoco-warp"];

pub fn budget(name: &str) -> Option<&'static Budget> {
    BUDGETS.iter().find(|budget| budget.name == name)
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    pub vertices: usize,
    pub faces: usize,
    pub triangles: usize,
    pub edges: usize,
    pub face_vertices: usize,
    /// Radius of the smallest ball around the centroid that contains the hull, divided by the
    /// radius of the largest one inside. At least what PhysX compares, since its box lies inside
    /// the hull. Infinite for a flat hull.
    pub aspect: f64,
    /// Smallest distance between a face and the vertex farthest from it; 0 for a flat hull.
    pub thickness: f64,
}

impl Figures {
    /// Complexity: O(vertices · faces) for the thickness within the limits of all engines. For a
    /// larger hull, it is twice the inner ball's radius.
    pub fn new(positions: &[[f32; 3]], polygons: &[Vec<u32>], centroid: DVec3) -> Self {
        let point = |corner: u32| {
            let position = positions.get(corner as usize).copied().unwrap_or_default();
            DVec3::from_array(position.map(f64::from))
        };
        let corners: usize = polygons.iter().map(Vec::len).sum();
        let (mut inner, mut thickness) = (f64::INFINITY, f64::INFINITY);
        let is_small = positions.len() <= LARGEST;
        for polygon in polygons {
            let normal = normal(polygon.iter().map(|&corner| point(corner)));
            let Some(&first) = polygon.first() else {
                continue;
            };
            let offset = normal.dot(point(first));
            inner = inner.min(offset - normal.dot(centroid));
            if is_small {
                let lowest = (0..positions.len() as u32).map(|vertex| normal.dot(point(vertex)));
                thickness = thickness.min(offset - lowest.fold(f64::INFINITY, f64::min));
            }
        }
        let outer = (0..positions.len() as u32).map(|vertex| point(vertex).distance(centroid)).fold(0.0, f64::max);
        Self {
            vertices: positions.len(),
            faces: polygons.len(),
            triangles: corners.saturating_sub(2 * polygons.len()),
            edges: corners / 2,
            face_vertices: polygons.iter().map(Vec::len).max().unwrap_or(0),
            aspect: if inner > 0.0 { outer / inner } else { f64::INFINITY },
            thickness: if is_small { thickness.max(0.0) } else { 2.0 * inner.max(0.0) },
        }
    }
}

const LARGEST: usize = 256;

/// Unit normal of a polygon, by the sum of its edges' cross products (Newell).
fn normal(corners: impl Iterator<Item = DVec3> + Clone) -> DVec3 {
    let next = corners.clone().cycle().skip(1);
    corners.zip(next).map(|(a, b)| a.cross(b)).sum::<DVec3>().normalize_or_zero()
}

impl Budget {
    /// The largest number of vertices for which every hull is within the limits on numbers.
    pub fn sure_vertices(&self) -> u32 {
        let limits = [
            Some(self.vertices),
            // There are at most as many polygons as triangles.
            self.faces.map(|faces| faces.saturating_add(4) / 2),
            self.triangles.map(|triangles| triangles.saturating_add(4) / 2),
            self.edges.map(|edges| edges.saturating_add(6) / 3),
            self.face_vertices.map(|corners| corners.saturating_add(1)),
        ];
        limits.into_iter().flatten().min().and_then(|least| u32::try_from(least).ok()).unwrap_or(u32::MAX)
    }

    pub fn vertices(&self) -> usize {
        self.vertices
    }

    /// The limits on numbers that a hull exceeds, in words. Fewer vertices meet them.
    pub fn exceeded_counts(&self, of: &Figures) -> Vec<String> {
        let counts = [
            (Some(self.vertices), of.vertices, "vertices"),
            (self.faces, of.faces, "faces"),
            (self.triangles, of.triangles, "triangles"),
            (self.edges, of.edges, "edges"),
            (self.face_vertices, of.face_vertices, "vertices of a face"),
        ];
        let exceeded = counts.into_iter().filter_map(|(limit, count, noun)| {
            let limit = limit.filter(|&limit| count > limit)?;
            Some(format!("{count} {noun}, and at most {limit} fit"))
        });
        exceeded.collect()
    }

    /// The limits on the form that a hull exceeds, in words. NaN takes the failing branch.
    pub fn exceeded_form(&self, of: &Figures) -> Vec<String> {
        let mut exceeded = Vec::new();
        if let Some(limit) = self.aspect
            && !(of.aspect <= limit)
        {
            exceeded.push(format!("an aspect of {:.1}:1, and at most {limit:.0}:1 fits", of.aspect));
        }
        if let Some(limit) = self.thickness
            && !(of.thickness >= limit)
        {
            let (found, limit) = (1000.0 * of.thickness, 1000.0 * limit);
            exceeded
                .push(format!("a thickness of {found:.2} mm if the unit is the metre, and at least {limit} mm fits"));
        }
        exceeded
    }

    /// All limits that a hull exceeds, in words, with what the engine does then and the remedy.
    pub fn exceeded(&self, of: &Figures) -> Vec<String> {
        let (name, otherwise) = (self.name, self.otherwise);
        let sentence =
            |limit, remedy| format!("not within the budget of {name}: it has {limit} ({otherwise}); {remedy}");
        let counts = self.exceeded_counts(of).into_iter();
        let counts = counts.map(|limit| sentence(limit, format!("bake it with --for {name}")));
        let form = self.exceeded_form(of).into_iter();
        counts.chain(form.map(|limit| sentence(limit, "thicken or divide the mesh".to_owned()))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn prism(n: u32, radius: f32, height: f32) -> (Vec<[f32; 3]>, Vec<Vec<u32>>) {
        let turn = |i: u32| std::f32::consts::TAU * i as f32 / n as f32;
        let ring = |z: f32| (0..n).map(move |i| [radius * turn(i).cos(), radius * turn(i).sin(), z]);
        let mut faces = vec![(0..n).rev().collect(), (n..2 * n).collect()];
        faces.extend((0..n).map(|i| vec![i, (i + 1) % n, n + (i + 1) % n, n + i]));
        (ring(0.0).chain(ring(height)).collect(), faces)
    }

    fn figures(n: u32, radius: f32, height: f32) -> Figures {
        let (positions, faces) = prism(n, radius, height);
        Figures::new(&positions, &faces, DVec3::new(0.0, 0.0, 0.5 * f64::from(height)))
    }

    #[test]
    fn the_table_has_every_name_once() {
        assert!(NAMES.iter().skip(1).eq(BUDGETS.iter().map(|budget| &budget.name)));
        assert!(BUDGETS.iter().all(|budget| !budget.source.is_empty() && !budget.otherwise.is_empty()));
        assert!(budget("none").is_none() && budget("box3d").is_some());
        assert!(BUDGETS.iter().all(|budget| budget.vertices <= LARGEST));
    }

    #[test]
    fn a_prism_has_the_figures_of_its_formulas() {
        for n in [3_u32, 4, 10, 43] {
            let found = figures(n, 2.0, 3.0);
            let count = n as usize;
            assert_eq!((found.vertices, found.faces, found.edges), (2 * count, count + 2, 3 * count));
            assert_eq!((found.triangles, found.face_vertices), (4 * count - 4, count.max(4)));
            let inner = (2.0 * (std::f64::consts::PI / f64::from(n)).cos()).min(1.5);
            assert!((found.aspect - 2.5 / inner).abs() < 1e-6, "{n}: {}", found.aspect);
        }
        let plate = figures(4, 1.0, 0.001);
        assert!((plate.thickness - 0.001).abs() < 1e-9 && plate.aspect > 1000.0, "{plate:?}");
        assert_eq!(Figures::new(&[[0.0; 3]; 3], &[], DVec3::ZERO).vertices, 3);
    }

    #[test]
    fn the_sure_number_of_vertices_is_the_largest() {
        let sure: Vec<u32> = BUDGETS.iter().map(Budget::sure_vertices).collect();
        assert_eq!(sure, [129, 33, 256, 44, 129, 32, 64, 64]);
        let triangulated = |vertices: usize| Figures {
            vertices,
            faces: 2 * vertices - 4,
            triangles: 2 * vertices - 4,
            edges: 3 * vertices - 6,
            face_vertices: 3,
            aspect: 1.0,
            thickness: 1.0,
        };
        for budget in &BUDGETS {
            let most = budget.sure_vertices() as usize;
            assert!(budget.exceeded_counts(&triangulated(most)).is_empty(), "{}", budget.name);
            let pyramid = Figures { face_vertices: most, ..triangulated(most + 1) };
            assert!(!budget.exceeded_counts(&pyramid).is_empty(), "{}", budget.name);
        }
    }

    #[test]
    fn what_does_not_fit_is_named() {
        let box3d = budget("box3d").unwrap();
        assert!(box3d.exceeded(&figures(42, 1.0, 1.0)).is_empty());
        let found = box3d.exceeded(&figures(43, 1.0, 0.004));
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found[0].contains("129 edges, and at most 128 fit") && found[1].contains("4.00 mm"), "{found:?}");
        assert!(found[0].ends_with("; bake it with --for box3d"), "{found:?}");
        assert!(found[1].ends_with("; thicken or divide the mesh"), "{found:?}");
        let gpu = budget("physx-gpu").unwrap();
        assert!(gpu.exceeded(&figures(32, 1.0, 1.0)).is_empty());
        assert!(gpu.exceeded(&figures(33, 1.0, 1.0)).len() == 2);
        assert!(gpu.exceeded(&figures(4, 0.01, 2.0))[0].contains(":1, and at most 64:1"));
        let flat = Figures { aspect: f64::NAN, thickness: f64::NAN, ..figures(4, 1.0, 1.0) };
        assert_eq!((gpu.exceeded_form(&flat).len(), box3d.exceeded_form(&flat).len()), (1, 1));
    }
}
