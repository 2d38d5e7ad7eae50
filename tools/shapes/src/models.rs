//! Models under `assets/`: small OBJ files, each with a purpose.
//!
//! Each represents a typical shape (round, flat-sided, thin, concave, of low rank) and a dialect of
//! OBJ (n-gons, relative indices, normals, groups, line endings, elements other than faces).

use crate::families::{self, Boulder, LENS_HALF_THICKNESS};
use crate::mesh::Mesh;
use crate::obj::{Corner, Document, Indexing, LineEnding, Object, Statement};
use crate::solids::{self, TorusKnot};
use crate::turn::cos_sin;
use crate::vector::{self, to_f32, to_f64};

/// A committed OBJ file and its description.
#[derive(Clone, Debug)]
pub struct Model {
    /// File name under `assets/`.
    pub file_name: &'static str,
    /// Title of a few words.
    pub title: &'static str,
    /// Features of the baker and of an OBJ reader that it exercises.
    pub exercises: &'static str,
    /// Affine rank of its vertices: 0 point, 1 line, 2 plane, 3 solid.
    pub rank: u32,
    /// Content of the file.
    pub document: Document,
}

impl Model {
    /// A model of rank 3 with one object. The header is its title.
    fn new(
        file_name: &'static str,
        title: &'static str,
        exercises: &'static str,
        parameters: String,
        objects: Vec<Object>,
    ) -> Self {
        let header = vec![
            format!("{title}."),
            format!("Parameters: {parameters}."),
            format!("Exercises: {exercises}."),
            "Made by make-assets (package shapes) from numbers alone; change it there.".to_owned(),
        ];
        Self { file_name, title, exercises, rank: 3, document: Document { header, objects, ..Document::default() } }
    }

    fn with_rank(mut self, rank: u32) -> Self {
        self.rank = rank;
        self
    }

    fn note(mut self, text: &str) -> Self {
        self.document.header.push(text.to_owned());
        self
    }
}

/// All models, in the order of the table in `assets/README.md`.
pub fn all() -> Vec<Model> {
    vec![
        tetrahedron(),
        cube(),
        octahedron(),
        dodecahedron(),
        icosahedron(),
        gear(),
        pawn(),
        rock(),
        torus_knot(),
        capsule(),
        prism_500(),
        cone(),
        lens(),
        two_objects(),
        flat_sheet(),
        point_cloud(),
        segment(),
        single_point(),
    ]
}

fn tetrahedron() -> Model {
    let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    let normals = corners.map(|c| vector::scale(c, -1.0));
    let mesh = solids::polyhedron(&corners, &normals);
    Model::new(
        "tetrahedron.obj",
        "Regular tetrahedron",
        "the smallest hull of rank 3; triangles",
        "every other corner of a cube of edge 2".into(),
        vec![Object::from_mesh(Some("tetrahedron"), &mesh)],
    )
}

fn cube() -> Model {
    let normals = solids::octahedron_vertices();
    let mesh = solids::polyhedron(&solids::cube_vertices(), &normals);
    let mut object = Object::new(Some("cube"));
    object.push_vertices(&mesh.vertices);
    for uv in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
        object.push(Statement::Texcoord(uv));
    }
    for &normal in &normals {
        object.push(Statement::Normal(to_f32(normal)));
    }
    object.push(Statement::Material("painted".into()));
    object.push(Statement::Smoothing(None));
    for (face, normal) in mesh.faces.iter().zip(0..) {
        let corners = face.iter().zip(0..).map(|(&vertex, texcoord)| Corner {
            vertex,
            texcoord: Some(texcoord),
            normal: Some(normal),
        });
        object.push(Statement::Face(corners.collect()));
    }
    let mut model = Model::new(
        "cube.obj",
        "Cube of quads",
        "coplanar triangles once quads are cut; v/vt/vn corners; a material library that does not exist",
        "edge 2, centred on the origin".into(),
        vec![object],
    )
    .note("The material library named below is missing on purpose: geometry must load without it.");
    model.document.material_library = Some("missing_on_purpose.mtl".into());
    model
}

fn octahedron() -> Model {
    let mesh = solids::polyhedron(&solids::octahedron_vertices(), &solids::cube_vertices());
    Model::new(
        "octahedron.obj",
        "Regular octahedron",
        "support ties between vertices in every axis plane; a file without an object name",
        "corners at distance 1 on each half-axis".into(),
        vec![Object::from_mesh(None, &mesh)],
    )
}

fn dodecahedron() -> Model {
    let mesh = solids::polyhedron(&solids::dodecahedron_vertices(), &solids::icosahedron_vertices());
    Model::new(
        "dodecahedron.obj",
        "Regular dodecahedron",
        "pentagons, coplanar only to the rounding of f32",
        "corners of a cube of edge 2, and twelve more: edge sqrt(5) - 1".into(),
        vec![Object::from_mesh(Some("dodecahedron"), &mesh)],
    )
}

fn icosahedron() -> Model {
    let mesh = solids::polyhedron(&solids::icosahedron_vertices(), &solids::dodecahedron_vertices());
    let mut object = Object::new(Some("icosahedron"));
    object.push_vertices(&mesh.vertices);
    let (upper, lower): (Vec<_>, Vec<_>) = mesh.faces.iter().cloned().partition(|face| {
        let heights = face.iter().map(|&v| mesh.vertices[v as usize][2]);
        heights.sum::<f32>() > 0.0
    });
    for (name, faces) in [("upper", upper), ("lower", lower)] {
        object.push(Statement::Group(name.into()));
        object.push(Statement::Smoothing(None));
        object.push_faces(&faces);
    }
    Model::new(
        "icosahedron.obj",
        "Regular icosahedron",
        "faces in two groups of one object, which share vertices: still one hull",
        "edge 2, two edges parallel to each axis".into(),
        vec![object],
    )
}

fn gear() -> Model {
    const TEETH: usize = 20;
    const TIP_RADIUS: f64 = 1.0;
    const ROOT_RADIUS: f64 = 0.8;
    const HALF_THICKNESS: f64 = 0.2;
    // A tooth takes eight parts of the turn: one up, two across the tip, one down, four along the
    // root.
    let at = |part: usize, radius: f64| {
        let (c, s) = cos_sin(part, 8 * TEETH);
        [radius * c, radius * s]
    };
    let outline: Vec<[f64; 2]> = (0..TEETH)
        .flat_map(|tooth| {
            [
                at(8 * tooth + 1, TIP_RADIUS),
                at(8 * tooth + 3, TIP_RADIUS),
                at(8 * tooth + 4, ROOT_RADIUS),
                at(8 * tooth + 8, ROOT_RADIUS),
            ]
        })
        .collect();
    let mesh = solids::extrusion(&outline, -HALF_THICKNESS, HALF_THICKNESS);
    let mut object = Object::new(Some("gear"));
    object.push_vertices(&mesh.vertices);
    object.push(Statement::Comment(
        "The next vertex marks the axle. No face uses it, and it lies outside the hull of those that are used:".into(),
    ));
    object.push(Statement::Comment("it counts with `--vertices all` and not with `--vertices referenced`.".into()));
    object.push(Statement::Vertex([0.0, 0.0, 1.0]));
    object.push(Statement::Group("caps".into()));
    object.push_faces(&mesh.faces[..2]);
    object.push(Statement::Group("teeth".into()));
    object.push_faces(&mesh.faces[2..]);
    Model::new(
        "gear.obj",
        "Spur gear",
        "a concave solid; concave n-gons as caps; one vertex that no face uses; groups",
        format!("{TEETH} teeth, tip radius {TIP_RADIUS}, root radius {ROOT_RADIUS}, half-thickness {HALF_THICKNESS}"),
        vec![object],
    )
}

fn pawn() -> Model {
    const SEGMENTS: u32 = 32;
    const WAIST_STEPS: usize = 8;
    const HEAD_RADIUS: f64 = 0.27;
    const HEAD_Z: f64 = 1.38;
    let mut profile =
        vec![[0.0, 0.0], [0.6, 0.0], [0.63, 0.05], [0.63, 0.15], [0.57, 0.22], [0.48, 0.25], [0.46, 0.32]];
    // The waist narrows along a parabola.
    for step in 0..=WAIST_STEPS {
        let t = step as f64 / WAIST_STEPS as f64;
        profile.push([0.17 + 0.19 * (1.0 - t) * (1.0 - t), 0.38 + 0.67 * t]);
    }
    profile.extend([[0.3, 1.09], [0.3, 1.13], [0.21, 1.17]]);
    // The head: latitudes from -45° in steps of 15°, then the pole.
    for step in 0..9 {
        let (c, s) = cos_sin(21 + step, 24);
        profile.push([HEAD_RADIUS * c, HEAD_Z + HEAD_RADIUS * s]);
    }
    profile.push([0.0, HEAD_Z + HEAD_RADIUS]);
    let mesh = solids::lathe(&profile, SEGMENTS);
    let mut object = Object::new(Some("pawn"));
    object.push_vertices(&mesh.vertices);
    object.push(Statement::Smoothing(Some(1)));
    object.push_faces(&mesh.faces);
    Model::new(
        "pawn.obj",
        "Chess pawn, turned on a lathe",
        "a concave render mesh most of whose vertices are inside the hull; flat base with its centre as a vertex",
        format!("{SEGMENTS} segments, {} points in the profile, height 1.65, greatest radius 0.63", profile.len()),
        vec![object],
    )
}

fn rock() -> Model {
    const SEED: u64 = 5;
    const LEVELS: u32 = 3;
    let boulder = Boulder::new(SEED);
    let (directions, triangles) = solids::geodesic(LEVELS);
    let mut mesh = Mesh::default();
    for &direction in &directions {
        mesh.push_vertex(boulder.support_point(direction));
    }
    mesh.faces = triangles.iter().map(|t| t.to_vec()).collect();
    let mut object = Object::new(Some("rock"));
    object.push_vertices(&mesh.vertices);
    object.push(Statement::Smoothing(Some(1)));
    object.push_faces(&mesh.faces);
    Model::new(
        "rock.obj",
        "Boulder with knobs",
        "every vertex on the hull, dense on the knobs and sparse between",
        format!(
            "seed {SEED}, {} knobs, one vertex for each direction of a geodesic sphere of {LEVELS} levels",
            Boulder::KNOB_COUNT
        ),
        vec![object],
    )
}

fn torus_knot() -> Model {
    let knot = TorusKnot {
        turns_about_axis: 2,
        turns_about_circle: 3,
        major_radius: 1.0,
        minor_radius: 0.4,
        tube_radius: 0.15,
        sections: 96,
        sides: 10,
    };
    let mesh = solids::torus_knot(knot);
    Model::new(
        "torus_knot.obj",
        "Torus knot",
        "a surface with a hole, nowhere near convex; quads that are not planar",
        format!(
            "({}, {}) knot, radii {} and {}, tube radius {}, {} sections of {} sides",
            knot.turns_about_axis,
            knot.turns_about_circle,
            knot.major_radius,
            knot.minor_radius,
            knot.tube_radius,
            knot.sections,
            knot.sides
        ),
        vec![Object::from_mesh(Some("torus_knot"), &mesh)],
    )
}

fn capsule() -> Model {
    const SEGMENTS: u32 = 32;
    const CAP_RINGS: usize = 8;
    const RADIUS: f64 = 0.5;
    const HALF_HEIGHT: f64 = 0.5;
    let cap = |ring: usize| {
        let (c, s) = cos_sin(ring, 4 * CAP_RINGS);
        [RADIUS * s, HALF_HEIGHT + RADIUS * c]
    };
    let upper: Vec<[f64; 2]> = (0..=CAP_RINGS).rev().map(cap).collect();
    let lower = upper.iter().rev().map(|&[r, z]| [r, -z]);
    let profile: Vec<[f64; 2]> = lower.chain(upper.iter().copied()).collect();
    let mesh = solids::lathe(&profile, SEGMENTS);
    let mut object = Object::new(Some("capsule"));
    object.push_vertices(&mesh.vertices);
    for &vertex in &mesh.vertices {
        let [x, y, z] = to_f64(vertex);
        let from_axis = [x, y, z - z.clamp(-HALF_HEIGHT, HALF_HEIGHT)];
        object.push(Statement::Normal(to_f32(vector::normalized(from_axis))));
    }
    object.push(Statement::Smoothing(Some(1)));
    for face in &mesh.faces {
        let corner = |&vertex: &u32| Corner { vertex, texcoord: None, normal: Some(vertex) };
        object.push(Statement::Face(face.iter().map(corner).collect()));
    }
    let mut model = Model::new(
        "capsule.obj",
        "Capsule",
        "round ends and long straight sides; v//vn corners; lines that end in CR LF",
        format!(
            "radius {RADIUS}, cylinder from z = -{HALF_HEIGHT} to {HALF_HEIGHT}, {SEGMENTS} segments, {CAP_RINGS} rings a cap"
        ),
        vec![object],
    );
    model.document.line_ending = LineEnding::CrLf;
    model
}

fn prism_500() -> Model {
    const CORNERS: usize = 500;
    let mesh = solids::extrusion(&solids::regular_polygon(CORNERS, 1.0), -1.0, 1.0);
    let mut object = Object::new(Some("prism_500"));
    object.push_vertices(&mesh.vertices);
    object.push(Statement::Group("bottom".into()));
    object.push_faces(&mesh.faces[..1]);
    object.push(Statement::Group("top".into()));
    object.push_faces(&mesh.faces[1..2]);
    object.push(Statement::Group("side".into()));
    object.push_faces(&mesh.faces[2..]);
    Model::new(
        "prism_500.obj",
        "Prism over a 500-gon",
        "caps of 500 corners on one line of text; hull faces with 500 edges; thin normal cones, hard on a direction index",
        format!("{CORNERS} corners a cap, radius 1, z from -1 to 1"),
        vec![object],
    )
}

fn cone() -> Model {
    const BASE_CORNERS: usize = 72;
    let mesh = solids::cone(BASE_CORNERS, 1.0, -1.0, 1.0);
    Model::new(
        "cone.obj",
        "Cone",
        "an apex with 72 neighbours, hard on hill climbing; one n-gon as base",
        format!("{BASE_CORNERS} corners in the base, radius 1, z from -1 to 1"),
        vec![Object::from_mesh(Some("cone"), &mesh)],
    )
}

fn lens() -> Model {
    const SEGMENTS: u32 = 48;
    const CAP_RINGS: usize = 5;
    let sphere_radius = families::lens_sphere_radius();
    let half_angle_rad = libm::asin(1.0 / sphere_radius);
    let cap = |ring: usize| {
        let angle_rad = half_angle_rad * ring as f64 / (CAP_RINGS + 1) as f64;
        let height = sphere_radius * libm::cos(angle_rad) - (sphere_radius - LENS_HALF_THICKNESS);
        [sphere_radius * libm::sin(angle_rad), height]
    };
    let upper: Vec<[f64; 2]> = (0..=CAP_RINGS).rev().map(cap).collect();
    let lower = upper.iter().rev().map(|&[r, z]| [r, -z]);
    let profile: Vec<[f64; 2]> = lower.chain([[1.0, 0.0]]).chain(upper.iter().copied()).collect();
    let mesh = solids::lathe(&profile, SEGMENTS);
    Model::new(
        "lens.obj",
        "Lens of two shallow caps",
        "a thin solid, twenty times as wide as thick; most normals close to the z axis",
        format!("rim radius 1, half-thickness {LENS_HALF_THICKNESS}, {SEGMENTS} segments, {CAP_RINGS} rings a cap"),
        vec![Object::from_mesh(Some("lens"), &mesh)],
    )
}

fn two_objects() -> Model {
    const OFFSET: f32 = 2.0;
    let moved = |mut mesh: Mesh, x: f32| {
        for vertex in &mut mesh.vertices {
            vertex[0] += x;
        }
        mesh
    };
    let cube = solids::polyhedron(&solids::cube_vertices(), &solids::octahedron_vertices());
    let octahedron = solids::polyhedron(&solids::octahedron_vertices(), &solids::cube_vertices());
    let left = Object::from_mesh(Some("left_cube"), &moved(cube, -OFFSET));
    let mut right = Object::from_mesh(Some("right_octahedron"), &moved(octahedron, OFFSET));
    right.indexing = Indexing::Relative;
    right.statements.insert(
        0,
        Statement::Comment("Faces of this object count back from its last vertex: -1 is the latest.".into()),
    );
    Model::new(
        "two_objects.obj",
        "Two solids in one file",
        "two named objects, one hull or two; negative indices in the second",
        format!("cube at x = -{OFFSET}, octahedron at x = {OFFSET}"),
        vec![left, right],
    )
}

fn flat_sheet() -> Model {
    const CELLS: u32 = 8;
    let row = CELLS + 1;
    let mut object = Object::new(Some("flat_sheet"));
    let coordinate = |i: u32| i as f32 * (2.0 / CELLS as f32) - 1.0;
    for (y, x) in (0..row * row).map(|i| (coordinate(i / row), coordinate(i % row))) {
        object.push(Statement::Vertex([x, y, x / 2.0 + y / 4.0]));
    }
    for i in 0..row * row {
        let fraction = |i: u32| i as f32 / CELLS as f32;
        object.push(Statement::Texcoord([fraction(i % row), fraction(i / row)]));
    }
    object.push(Statement::Normal(to_f32(vector::normalized([-0.5, -0.25, 1.0]))));
    for i in 0..CELLS * CELLS {
        let first = i / CELLS * row + i % CELLS;
        let corner = |vertex| Corner { vertex, texcoord: Some(vertex), normal: Some(0) };
        let corners = [first, first + 1, first + row + 1, first + row].map(corner);
        object.push(Statement::Face(corners.to_vec()));
    }
    Model::new(
        "flat_sheet.obj",
        "Flat, oblique sheet",
        "rank 2: points exactly in one plane that is not along an axis, few of them extreme",
        format!("{CELLS} by {CELLS} quads, x and y in [-1, 1], z = x/2 + y/4 without rounding"),
        vec![object],
    )
    .with_rank(2)
}

fn point_cloud() -> Model {
    const POINTS: usize = 500;
    const SEED: u64 = 17;
    let mut object = Object::new(None);
    object.push_vertices(&families::ball(POINTS, SEED));
    Model::new(
        "point_cloud.obj",
        "Point cloud",
        "bare vertices without any element: nothing is referenced, so all of them must count",
        format!("{POINTS} points of the family `ball`, seed {SEED}"),
        vec![object],
    )
}

fn segment() -> Model {
    let mut object = Object::new(Some("segment"));
    object.push_vertices(&[[0.0, 0.0, 0.0], [0.5, 1.0, -0.25], [1.0, 2.0, -0.5]]);
    object.push(Statement::Line(vec![0, 1, 2]));
    Model::new(
        "segment.obj",
        "Segment",
        "rank 1: a line element of three points exactly in line, the middle one not extreme",
        "(0, 0, 0) to (1, 2, -0.5), and the point half-way".into(),
        vec![object],
    )
    .with_rank(1)
}

fn single_point() -> Model {
    let mut object = Object::new(Some("single_point"));
    object.push_vertices(&[[1.0, 2.0, 3.0]]);
    object.push(Statement::Points(vec![0]));
    Model::new(
        "single_point.obj",
        "Single point",
        "rank 0: a point element; a support point that is the same in every direction",
        "(1, 2, 3)".into(),
        vec![object],
    )
    .with_rank(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::{cross, dot, length, sub};
    use std::collections::HashSet;

    fn model(file_name: &str) -> Model {
        all().into_iter().find(|m| m.file_name == file_name).unwrap()
    }

    fn vertices(model: &Model) -> Vec<[f64; 3]> {
        let objects = model.document.objects.iter();
        objects.flat_map(|o| o.mesh().vertices).map(to_f64).collect()
    }

    /// Affine rank by brute force. Where it is below 3, the models are exact, so zero means zero.
    fn rank(points: &[[f64; 3]]) -> u32 {
        let spans: Vec<_> = points.iter().map(|&p| sub(p, points[0])).collect();
        let Some(&a) = spans.iter().find(|s| length(**s) > 0.0) else {
            return 0;
        };
        let Some(normal) = spans.iter().map(|&b| cross(a, b)).find(|n| length(*n) > 0.0) else {
            return 1;
        };
        if spans.iter().all(|&c| dot(c, normal) == 0.0) { 2 } else { 3 }
    }

    #[test]
    fn ranks_are_as_stated() {
        for model in all() {
            assert_eq!(rank(&vertices(&model)), model.rank, "{}", model.file_name);
        }
    }

    #[test]
    fn solids_are_closed_and_wind_outwards() {
        let mut solids = 0;
        for model in all().iter().filter(|m| m.rank == 3) {
            for object in &model.document.objects {
                let mesh = object.mesh();
                if mesh.faces.is_empty() {
                    continue;
                }
                assert_eq!(mesh.check_closed(), Ok(()), "{}", model.file_name);
                assert!(mesh.signed_volume() > 0.0, "{}", model.file_name);
                solids += 1;
            }
        }
        assert_eq!(solids, 15);
    }

    #[test]
    fn vertices_are_distinct() {
        for model in all() {
            let points = vertices(&model);
            let bits: HashSet<_> = points.iter().map(|p| p.map(f64::to_bits)).collect();
            assert_eq!(bits.len(), points.len(), "{}", model.file_name);
        }
    }

    #[test]
    fn only_the_gear_has_an_unreferenced_vertex_among_its_faces() {
        for model in all() {
            for object in &model.document.objects {
                let mesh = object.mesh();
                let expected = match model.file_name {
                    _ if mesh.faces.is_empty() => continue,
                    "gear.obj" => vec![160],
                    _ => vec![],
                };
                assert_eq!(mesh.unreferenced_vertices(), expected, "{}", model.file_name);
            }
        }
    }

    #[test]
    fn prism_500_has_the_promised_counts() {
        let document = model("prism_500.obj").document;
        assert_eq!(document.vertex_count(), 1_000);
        assert_eq!(document.face_count(), 502);
        let faces = document.objects[0].mesh().faces;
        assert_eq!([faces[0].len(), faces[1].len()], [500, 500]);
    }

    #[test]
    fn dialects_are_as_promised() {
        let text = |name: &str| model(name).document.to_text();
        assert!(text("cube.obj").contains("mtllib missing_on_purpose.mtl\n"));
        assert!(text("two_objects.obj").contains("\nf -"));
        assert!(text("segment.obj").contains("\nl 1 2 3\n"));
        assert!(text("single_point.obj").contains("\np 1\n"));
        assert!(!text("octahedron.obj").contains("\no "));
        for model in all() {
            let text = model.document.to_text();
            // Some readers reject bytes above 127, even in comments.
            assert!(text.is_ascii(), "{}", model.file_name);
            let (lines, crlf) = (text.matches('\n').count(), text.matches("\r\n").count());
            let expected = if model.file_name == "capsule.obj" { lines } else { 0 };
            assert_eq!(crlf, expected, "{}", model.file_name);
        }
    }
}
