//! Wavefront OBJ text.
//!
//! A [`Document`] lists the statements of a file, so that a few types can write the dialects of
//! real files: absolute and relative indices, n-gons, lines and points, groups, materials, both
//! line endings.
//!
//! Numbers are written with Rust's `{}`: the shortest decimal that parses to the same `f32`,
//! without an exponent, and the same on every machine. Negative zero is written as zero.
//!
//! # Reference
//! "Object Files (.obj)", Appendix B1 of the Wavefront Advanced Visualizer manual, version 3.0.

use crate::mesh::Mesh;
use std::fmt::{self, Display, Write};

/// Line ending.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LineEnding {
    /// Line feed.
    #[default]
    Lf,
    /// Carriage return and line feed.
    CrLf,
}

/// Form of the vertex references in an object.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Indexing {
    /// Positive: 1 is the first vertex of the file.
    #[default]
    Absolute,
    /// Negative: -1 is the last vertex above the reference.
    Relative,
}

/// A corner of a face. All indices are zero-based and count within the object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Corner {
    /// Index among the object's vertices.
    pub vertex: u32,
    /// Index among the object's texture coordinates.
    pub texcoord: Option<u32>,
    /// Index among the object's normals.
    pub normal: Option<u32>,
}

/// One line of an object. Indices are zero-based and count within the object.
#[derive(Clone, Debug, PartialEq)]
pub enum Statement {
    /// `# text`
    Comment(String),
    /// `v x y z`
    Vertex([f32; 3]),
    /// `vt u v`
    Texcoord([f32; 2]),
    /// `vn x y z`
    Normal([f32; 3]),
    /// `g name`
    Group(String),
    /// `s number`, or `s off` for `None`
    Smoothing(Option<u32>),
    /// `usemtl name`
    Material(String),
    /// `f …`
    Face(Vec<Corner>),
    /// `l …`, a polyline
    Line(Vec<u32>),
    /// `p …`
    Points(Vec<u32>),
}

/// Statements under an `o` line, or before the first one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Object {
    /// Name on the `o` line. `None` omits the line.
    pub name: Option<String>,
    /// Form of the references of faces, lines and points.
    pub indexing: Indexing,
    /// The lines, in order.
    pub statements: Vec<Statement>,
}

impl Object {
    /// An object without statements.
    pub fn new(name: Option<&str>) -> Self {
        Self { name: name.map(str::to_owned), ..Self::default() }
    }

    /// An object of the vertices of a mesh, then its faces.
    pub fn from_mesh(name: Option<&str>, mesh: &Mesh) -> Self {
        let mut object = Self::new(name);
        object.push_vertices(&mesh.vertices);
        object.push_faces(&mesh.faces);
        object
    }

    /// Adds one statement.
    pub fn push(&mut self, statement: Statement) {
        self.statements.push(statement);
    }

    /// Adds a `v` line for each vertex.
    pub fn push_vertices(&mut self, vertices: &[[f32; 3]]) {
        self.statements.extend(vertices.iter().copied().map(Statement::Vertex));
    }

    /// Adds an `f` line for each face, with vertex indices only.
    pub fn push_faces(&mut self, faces: &[Vec<u32>]) {
        let corner = |&vertex: &u32| Corner { vertex, texcoord: None, normal: None };
        self.statements.extend(faces.iter().map(|face| Statement::Face(face.iter().map(corner).collect())));
    }

    /// Vertices and faces of the object.
    pub fn mesh(&self) -> Mesh {
        let mut mesh = Mesh::default();
        for statement in &self.statements {
            match statement {
                Statement::Vertex(position) => mesh.vertices.push(*position),
                Statement::Face(corners) => mesh.faces.push(corners.iter().map(|corner| corner.vertex).collect()),
                _ => {}
            }
        }
        mesh
    }
}

/// A whole OBJ file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Document {
    /// Comment lines at the top, without their `#`.
    pub header: Vec<String>,
    /// File name on the `mtllib` line. `None` omits the line.
    pub material_library: Option<String>,
    /// The objects, in order.
    pub objects: Vec<Object>,
    /// Line ending.
    pub line_ending: LineEnding,
}

impl Document {
    /// Number of `v` lines.
    pub fn vertex_count(&self) -> usize {
        self.statements().filter(|s| matches!(s, Statement::Vertex(_))).count()
    }

    /// Number of `f` lines.
    pub fn face_count(&self) -> usize {
        self.statements().filter(|s| matches!(s, Statement::Face(_))).count()
    }

    fn statements(&self) -> impl Iterator<Item = &Statement> {
        self.objects.iter().flat_map(|object| &object.statements)
    }

    /// The file's text. Panics if a number is not finite, or an element references something that
    /// its object does not list above it.
    pub fn to_text(&self) -> String {
        let mut writer = Writer {
            text: String::new(),
            end: match self.line_ending {
                LineEnding::Lf => "\n",
                LineEnding::CrLf => "\r\n",
            },
        };
        for comment in &self.header {
            writer.comment(comment);
        }
        if let Some(library) = &self.material_library {
            writer.line(format_args!("mtllib {library}"));
        }
        let mut before = Counts::default();
        for object in &self.objects {
            before = writer.object(object, before);
        }
        writer.text
    }
}

#[derive(Clone, Copy, Default)]
struct Counts {
    vertices: u32,
    texcoords: u32,
    normals: u32,
}

struct Writer {
    text: String,
    end: &'static str,
}

impl Writer {
    fn line(&mut self, content: impl Display) {
        write!(self.text, "{content}{}", self.end).expect("writing to a string does not fail");
    }

    fn comment(&mut self, text: &str) {
        if text.is_empty() {
            self.line("#");
        } else {
            self.line(format_args!("# {text}"));
        }
    }

    /// Writes an object and returns the counts after it, given those before it.
    fn object(&mut self, object: &Object, before: Counts) -> Counts {
        if let Some(name) = &object.name {
            self.line(format_args!("o {name}"));
        }
        let mut here = Counts::default();
        for statement in &object.statements {
            match statement {
                Statement::Comment(text) => self.comment(text),
                Statement::Vertex(xyz) => {
                    here.vertices += 1;
                    self.line(format_args!("v {}", Numbers(xyz)));
                }
                Statement::Texcoord(uv) => {
                    here.texcoords += 1;
                    self.line(format_args!("vt {}", Numbers(uv)));
                }
                Statement::Normal(xyz) => {
                    here.normals += 1;
                    self.line(format_args!("vn {}", Numbers(xyz)));
                }
                Statement::Group(name) => self.line(format_args!("g {name}")),
                Statement::Smoothing(None) => self.line("s off"),
                Statement::Smoothing(Some(number)) => self.line(format_args!("s {number}")),
                Statement::Material(name) => self.line(format_args!("usemtl {name}")),
                Statement::Face(corners) => {
                    self.element("f", corners, |corner| corner_text(*corner, object.indexing, before, here));
                }
                Statement::Line(vertices) => self.element("l", vertices, |&vertex| {
                    index(vertex, object.indexing, before.vertices, here.vertices).to_string()
                }),
                Statement::Points(vertices) => self.element("p", vertices, |&vertex| {
                    index(vertex, object.indexing, before.vertices, here.vertices).to_string()
                }),
            }
        }
        Counts {
            vertices: before.vertices + here.vertices,
            texcoords: before.texcoords + here.texcoords,
            normals: before.normals + here.normals,
        }
    }

    fn element<T>(&mut self, keyword: &str, corners: &[T], text: impl Fn(&T) -> String) {
        let corners: Vec<String> = corners.iter().map(text).collect();
        self.line(format_args!("{keyword} {}", corners.join(" ")));
    }
}

/// `v`, `v/vt`, `v//vn` or `v/vt/vn`.
fn corner_text(corner: Corner, indexing: Indexing, before: Counts, here: Counts) -> String {
    let mut text = index(corner.vertex, indexing, before.vertices, here.vertices).to_string();
    if let Some(texcoord) = corner.texcoord {
        let number = index(texcoord, indexing, before.texcoords, here.texcoords);
        text.push_str(&format!("/{number}"));
    }
    if let Some(normal) = corner.normal {
        let slashes = if corner.texcoord.is_some() { "/" } else { "//" };
        let number = index(normal, indexing, before.normals, here.normals);
        text.push_str(&format!("{slashes}{number}"));
    }
    text
}

/// A zero-based index within an object, as the file counts it.
fn index(local: u32, indexing: Indexing, before: u32, here: u32) -> i64 {
    assert!(local < here, "an element names item {local} of an object that has listed only {here}");
    match indexing {
        Indexing::Absolute => i64::from(before) + i64::from(local) + 1,
        Indexing::Relative => i64::from(local) - i64::from(here),
    }
}

/// Numbers separated by spaces.
struct Numbers<'a>(&'a [f32]);

impl Display for Numbers<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, &number) in self.0.iter().enumerate() {
            assert!(number.is_finite(), "OBJ has no text for {number}");
            if i > 0 {
                f.write_str(" ")?;
            }
            // -0 + 0 is +0.
            write!(f, "{}", number + 0.0)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::SplitMix64;

    #[test]
    fn numbers_read_back_to_the_same_bits() {
        let mut rng = SplitMix64::new(11);
        let awkward = [f32::MIN_POSITIVE, f32::MAX, f32::from_bits(1), 0.1, 1.0 / 3.0, -1e-30];
        let random = (0..20_000).map(|_| f32::from_bits(rng.next_u64() as u32));
        for number in awkward.into_iter().chain(random.filter(|x| x.is_finite())) {
            let text = Numbers(&[number]).to_string();
            assert!(!text.contains(['e', 'E']), "{text}");
            assert_eq!(text.parse::<f32>().unwrap() + 0.0, number + 0.0);
            assert_eq!((text.parse::<f32>().unwrap() + 0.0).to_bits(), (number + 0.0).to_bits());
        }
        assert_eq!(Numbers(&[-0.0, 1.0, -0.5]).to_string(), "0 1 -0.5");
    }

    #[test]
    #[should_panic(expected = "OBJ has no text for NaN")]
    fn not_a_number_is_rejected() {
        let _ = Numbers(&[f32::NAN]).to_string();
    }

    #[test]
    fn every_statement_has_its_text() {
        let corner = |vertex, texcoord, normal| Corner { vertex, texcoord, normal };
        let mut first = Object::new(Some("first"));
        first.push_vertices(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        first.push(Statement::Texcoord([0.5, 0.25]));
        first.push(Statement::Normal([0.0, 0.0, 1.0]));
        first.push(Statement::Comment(String::new()));
        first.push(Statement::Group("side".into()));
        first.push(Statement::Smoothing(None));
        first.push(Statement::Smoothing(Some(2)));
        first.push(Statement::Material("red".into()));
        first.push(Statement::Face(vec![corner(0, None, None), corner(1, Some(0), None), corner(2, None, Some(0))]));
        let mut second = Object::new(None);
        second.indexing = Indexing::Relative;
        second.push_vertices(&[[2.0; 3], [3.0; 3]]);
        second.push(Statement::Line(vec![0, 1]));
        second.push(Statement::Points(vec![1]));
        let mut third = Object::new(Some("third"));
        third.push_vertices(&[[4.0; 3]]);
        third.push(Statement::Texcoord([0.0, 0.0]));
        third.push(Statement::Normal([1.0, 0.0, 0.0]));
        third.push(Statement::Face(vec![corner(0, Some(0), Some(0)); 3]));
        let document = Document {
            header: vec!["top".into()],
            material_library: Some("none.mtl".into()),
            objects: vec![first, second, third],
            line_ending: LineEnding::Lf,
        };
        let expected = "\
# top
mtllib none.mtl
o first
v 0 0 0
v 1 0 0
v 0 1 0
vt 0.5 0.25
vn 0 0 1
#
g side
s off
s 2
usemtl red
f 1 2/1 3//1
v 2 2 2
v 3 3 3
l -2 -1
p -1
o third
v 4 4 4
vt 0 0
vn 1 0 0
f 6/2/2 6/2/2 6/2/2
";
        assert_eq!(document.to_text(), expected);
        let crlf = Document { line_ending: LineEnding::CrLf, ..document };
        assert_eq!(crlf.to_text(), expected.replace('\n', "\r\n"));
    }

    #[test]
    #[should_panic(expected = "names item 1 of an object that has listed only 1")]
    fn index_that_is_not_listed_is_rejected() {
        let mut object = Object::new(None);
        object.push_vertices(&[[0.0; 3]]);
        object.push(Statement::Points(vec![1]));
        let document = Document { objects: vec![object], ..Document::default() };
        document.to_text();
    }
}
