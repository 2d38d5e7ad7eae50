use hullmap::{EdgeClass, TriangleMesh};
use hullmap_bake::triangle_mesh::{TJunctions, Triangles, bake_triangle_mesh, write_triangle_mesh};
use hullmap_bake::{PointSet, SourceRecord, fit};
use hullmap_geometry::number::grouped;
use hullmap_import::{Imported, Materials};

const MAX_MATERIALS: usize = 1000;

/// The contents of a triangle mesh. Field names are the JSON's.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct MeshSummary {
    /// Number of triangles.
    pub triangles: usize,
    /// Number of different vertices.
    pub vertices: usize,
    /// Number of vertices of the source that equal an earlier one.
    pub merged: usize,
    /// Number of triangles whose corners are on a line.
    pub degenerate: usize,
    /// Number of triangles with the same three vertices as an earlier one.
    pub duplicate: usize,
    /// Number of T-junctions: vertices between the ends of a border edge; `None`: not counted.
    pub t_junctions: Option<usize>,
    /// Numbers of edges.
    pub edges: EdgeCounts,
    /// Names of the materials from number 1 on, at most 1,000; `None` if the mesh was
    /// not baked now, because the file has numbers alone.
    pub materials: Option<Vec<String>>,
}

/// Number of edges of triangles with each class. An edge that two triangles share counts for both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct EdgeCounts {
    /// No other triangle has the edge.
    pub border: usize,
    /// The neighbour continues in the same plane.
    pub flat: usize,
    /// A ridge.
    pub convex: usize,
    /// A valley.
    pub concave: usize,
    /// More than two triangles have the edge.
    pub non_manifold: usize,
    /// The neighbour has the other side in front.
    pub reversed: usize,
}

impl EdgeCounts {
    /// Counts `count` edges of a class.
    pub fn add(&mut self, class: EdgeClass, count: usize) {
        *match class {
            EdgeClass::Border => &mut self.border,
            EdgeClass::Flat => &mut self.flat,
            EdgeClass::Convex => &mut self.convex,
            EdgeClass::Concave => &mut self.concave,
            EdgeClass::NonManifold => &mut self.non_manifold,
            EdgeClass::Reversed => &mut self.reversed,
        } += count;
    }

    /// Each number with the name of its class.
    pub fn named(&self) -> [(usize, &'static str); 6] {
        [
            (self.border, "border"),
            (self.flat, "flat"),
            (self.convex, "convex"),
            (self.concave, "concave"),
            (self.non_manifold, "non-manifold"),
            (self.reversed, "reversed"),
        ]
    }
}

impl MeshSummary {
    /// Counts from a mesh's file, without T-junctions, in O(triangles).
    pub fn of_file(mesh: &TriangleMesh) -> Self {
        let mut edges = EdgeCounts::default();
        let classes = (0..mesh.triangle_count()).filter_map(|triangle| mesh.edge_classes(triangle));
        classes.flatten().for_each(|class| edges.add(class, 1));
        Self {
            triangles: mesh.triangle_count(),
            vertices: mesh.vertex_count(),
            merged: mesh.merged_count(),
            degenerate: mesh.degenerate_count(),
            duplicate: mesh.duplicate_count(),
            t_junctions: None,
            edges,
            materials: None,
        }
    }

    /// The counts of flaws in words, or that there are none.
    pub fn flaws(&self) -> String {
        let counts = [
            (self.degenerate, "degenerate triangle", "degenerate triangles"),
            (self.duplicate, "duplicate triangle", "duplicate triangles"),
            (self.edges.non_manifold, "non-manifold edge of a triangle", "non-manifold edges of triangles"),
            (self.edges.reversed, "reversed edge of a triangle", "reversed edges of triangles"),
            (self.t_junctions.unwrap_or_default(), "T-junction", "T-junctions"),
        ];
        let found = counts.iter().filter(|(count, ..)| *count > 0);
        let texts: Vec<String> = found.map(|(count, one, many)| counted(*count, one, many)).collect();
        if texts.is_empty() { "none".to_owned() } else { texts.join(", ") }
    }
}

/// T-junctions of a mesh, in O(n log n) for n triangles.
pub fn t_junctions_of(mesh: &TriangleMesh) -> TJunctions {
    let vertices: Vec<[f32; 3]> =
        (0..mesh.vertex_count()).filter_map(|vertex| mesh.vertex(vertex)).map(|vertex| vertex.to_array()).collect();
    let triangles: Vec<[u32; 3]> = (0..mesh.triangle_count()).filter_map(|triangle| mesh.corners(triangle)).collect();
    let packed = |classes: [EdgeClass; 3]| {
        classes.iter().enumerate().fold(0, |word, (edge, class)| word | class.code() << (4 * edge))
    };
    let classes: Vec<u16> =
        (0..mesh.triangle_count()).filter_map(|triangle| mesh.edge_classes(triangle)).map(packed).collect();
    hullmap_bake::triangle_mesh::t_junctions(&vertices, &triangles, &classes)
}

/// A triangle mesh in memory.
#[derive(Clone, Debug, Default)]
pub struct BakedTriangles {
    /// The bytes of the file.
    pub bytes: Vec<u8>,
    /// Its contents.
    pub summary: MeshSummary,
    /// Findings of interest.
    pub notes: Vec<String>,
    /// Findings to act on, including findings of the import. The file keeps them.
    pub warnings: Vec<String>,
}

/// Bakes the triangles of a source that was imported as a whole, with the warnings of `source` and
/// about the mesh.
pub fn bake_triangles(imported: &Imported, source: &SourceRecord) -> Result<BakedTriangles, String> {
    let (Some(points), Some(faces)) = (imported.point_sets.first(), imported.faces.first()) else {
        return Err(NO_FACES.to_owned());
    };
    if points.triangles.is_empty() {
        return Err(NO_FACES.to_owned());
    }
    let materials = imported.materials.of_triangles(&faces.ends).ok_or_else(|| {
        let count = imported.materials.names().len();
        format!("has {count} materials, and a triangle mesh has at most {}; merge some", u16::MAX)
    })?;
    let triangles = Triangles { positions: &points.positions, corners: &points.triangles, materials: &materials };
    let baked = bake_triangle_mesh(&triangles).map_err(|error| error.to_string())?;
    let (counts, junctions) = (baked.counts(), baked.t_junctions());
    let mut edges = EdgeCounts::default();
    for (class, count) in EdgeClass::ALL.into_iter().zip(counts.edges) {
        edges.add(class, count);
    }
    let summary = MeshSummary {
        triangles: counts.triangles,
        vertices: counts.vertices,
        merged: counts.merged,
        degenerate: counts.degenerate,
        duplicate: counts.duplicate,
        t_junctions: Some(junctions.count),
        edges,
        materials: Some(imported.materials.names().iter().take(MAX_MATERIALS).cloned().collect()),
    };
    let mut source = source.clone();
    source.warnings.extend(warnings(&summary, junctions, &imported.materials, points));
    let bytes = write_triangle_mesh(baked, &source).map_err(|error| error.to_string())?;
    Ok(BakedTriangles { bytes, notes: notes(&summary), summary, warnings: source.warnings })
}

const NO_FACES: &str = "has no faces, and --keep-triangles requires some; leave it out, or remove --keep-triangles";

const REMEDIES: [(&str, &str); 4] = [
    (
        "--set recentre=true keeps the precision of the file",
        "move it to the origin in its editor, and place it by a pose",
    ),
    ("use --set recentre=true", "move them to the origin in an editor"),
    (" (--set vertices=all includes them)", ""),
    ("; --set vertices=all takes their control points", ""),
];

pub fn adapted(remark: &str) -> String {
    REMEDIES.iter().fold(remark.to_owned(), |text, (of_hulls, instead)| text.replace(of_hulls, instead))
}

fn notes(summary: &MeshSummary) -> Vec<String> {
    let mut notes = Vec::new();
    if summary.degenerate > 0 {
        let triangles = counted(summary.degenerate, "triangle has", "triangles have");
        notes.push(format!("{triangles} no area (degenerate), kept"));
    }
    if summary.duplicate > 0 {
        let triangles = counted(summary.duplicate, "triangle has", "triangles have");
        notes.push(format!("{triangles} the same corners as an earlier one (duplicate), kept"));
    }
    notes
}

fn warnings(summary: &MeshSummary, junctions: TJunctions, materials: &Materials, points: &PointSet) -> Vec<String> {
    let mut warnings = Vec::new();
    if summary.edges.non_manifold > 0 {
        let edges = counted(summary.edges.non_manifold, "edge of a triangle is", "edges of triangles are");
        warnings.push(format!(
            "{edges} not manifold: more than two triangles meet there; contact normals are not corrected there: remove \
             inner faces"
        ));
    }
    if summary.edges.reversed > 0 {
        let edges = counted(summary.edges.reversed, "edge of a triangle is", "edges of triangles are");
        let why = match fit::reversed(points).0.as_slice() {
            [] => "two triangles have their fronts on opposite sides".to_owned(),
            [triangle] => format!("triangle {triangle} is reversed"),
            [first, others @ ..] => format!("triangle {first} and {} more are reversed", grouped(others.len() as u64)),
        };
        warnings.push(format!("{edges} reversed: {why}; make the orientation of the faces consistent"));
    }
    if junctions.count > 0 {
        let at_least = if junctions.is_complete { "" } else { "at least " };
        let vertices = counted(junctions.count, "vertex lies", "vertices lie");
        warnings.push(format!(
            "{at_least}{vertices} between the ends of a border edge (T-junctions): the triangles there are no \
             neighbours; split these edges, or merge the vertices"
        ));
    }
    if materials.unknown_count() > 0 {
        let references = counted(materials.unknown_count(), "primitive names", "primitives name");
        warnings.push(format!(
            "{references} a material that the file does not have; their triangles get number 0: export the file again"
        ));
    }
    warnings
}

fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{} {}", grouped(count as u64), if count == 1 { one } else { many })
}
