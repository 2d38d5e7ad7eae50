//! A description of a robot: its links, and the geometry of each.

use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::chain::Chain;
use crate::document::Document;
use crate::error::RobotError;
use crate::frame::Frame;
use crate::mjcf::model::Model;
use crate::places::{NamedPackage, Places, Scheme, Unresolved, relative};
use crate::primitive::NamedPrimitive;

/// Format of a description.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Unified Robot Description Format, of ROS.
    Urdf,
    /// MuJoCo's XML.
    Mjcf,
    /// Simulation Description Format, of Gazebo.
    Sdf,
}

impl Format {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Urdf => "URDF",
            Self::Mjcf => "MJCF",
            Self::Sdf => "SDF",
        }
    }
}

/// A description, as it was read.
#[derive(Debug)]
pub struct Description {
    /// Its format.
    pub format: Format,
    /// The name of the robot; may be empty.
    pub name: String,
    /// The file, then the files that it includes.
    pub documents: Vec<Document>,
    /// The links, in the order of the file; bodies in MJCF.
    pub links: Vec<Link>,
    /// Files that it names by paths relative to its folder.
    pub references: Vec<Reference>,
    /// Elements that are left alone, with reasons.
    pub notes: Vec<String>,
    /// Models that it attaches or includes, whose collisions stay.
    pub others: Vec<OtherModel>,
    /// Faults that programs reject or read in different ways, each with its file and line.
    pub warnings: Vec<String>,
    /// How its joints move the links.
    pub chain: Chain,
    /// Its statements about contacts.
    pub contacts: Contacts,
    /// Elements whose geometry is not among the links.
    pub unread: Vec<Unread>,
    pub(crate) mesh_names: MeshNames,
    pub(crate) mjcf: Option<Model>,
}

/// Statements of an MJCF file about contacts. Other formats have none.
#[derive(Clone, Debug, Default)]
pub struct Contacts {
    /// Pairs of links without contacts: `exclude`.
    pub excluded: Vec<[usize; 2]>,
    /// Pairs of geoms that are always tested: `pair`, each a link and an index of its collisions.
    pub paired: Vec<[[usize; 2]; 2]>,
    /// Whether parents and children are tested: the flag `filterparent` is disabled.
    pub tests_parents: bool,
    /// Whether nothing is tested: the flag `contact` or `constraint` is disabled.
    pub is_disabled: bool,
}

/// An element whose geometry is not among the links.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unread {
    /// Index of its document.
    pub document: usize,
    /// Its line, from 1.
    pub line: u32,
    /// The element, as in a message: "`attach`", for instance.
    pub element: String,
    /// Why it is not read.
    pub reason: &'static str,
}

#[derive(Clone, Debug, Default)]
pub(crate) struct MeshNames {
    pub packages: Vec<NamedPackage>,
    /// Folder relative to the description, from which names of meshes start.
    pub folder: String,
    /// The only folder of meshes, relative to the description, if programs ignore folders in names.
    pub only_folder: Option<String>,
}

/// A rigid body of a robot.
#[derive(Clone, Debug)]
pub struct Link {
    /// Its name; in SDF qualified by the models that hold it.
    pub name: String,
    /// Index of its document.
    pub document: usize,
    /// Its line, from 1.
    pub line: u32,
    /// Its collision shapes.
    pub collisions: Vec<Shape>,
    /// Shapes that are only drawn.
    pub visuals: Vec<Shape>,
    pub(crate) at: usize,
    /// Whether a collision may be made from its visuals.
    pub takes_visuals: bool,
    /// The mass that it states; in MJCF in `inertial`.
    pub mass: Option<f64>,
}

impl Link {
    /// The meshes of its collisions, then of its visuals.
    pub fn meshes(&self) -> impl Iterator<Item = &MeshUse> {
        let shapes = self.collisions.iter().chain(&self.visuals);
        shapes.filter_map(|shape| match &shape.geometry {
            Geometry::Mesh(mesh) => Some(mesh),
            _ => None,
        })
    }
}

/// An element with a geometry.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Its name; may be empty.
    pub name: String,
    /// Index of its document.
    pub document: usize,
    /// Its line, from 1.
    pub line: u32,
    /// Its geometry.
    pub geometry: Geometry,
    /// Its frame in the link's; `None` if it is not known.
    pub pose: Option<Frame>,
    /// The bits by which MuJoCo decides which geoms meet: `contype` and `conaffinity`.
    pub contact_bits: [i32; 2],
    /// Whether programs draw it: visuals, and geoms of a group that is shown by default.
    pub is_drawn: bool,
    /// Why it must stay a single mesh, if so.
    pub stays_single: Option<String>,
    /// Where its element starts.
    pub(crate) at: usize,
}

/// Geometry of a shape.
#[derive(Clone, Debug, PartialEq)]
pub enum Geometry {
    /// A mesh.
    Mesh(MeshUse),
    /// A box, cylinder, sphere or another primitive.
    Primitive(NamedPrimitive),
    /// A geometry that cannot become a hull, with the reason.
    Other(String),
}

/// Use of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshUse {
    /// Its name as it is written.
    pub written: String,
    /// Its file, or why there is none.
    pub file: Result<PathBuf, Unresolved>,
    /// Factors along the axes of the mesh; negative ones mirror it.
    pub scale: [f64; 3],
    /// The frame in which the mesh is drawn and scaled, relative to the frame of its file: `refpos`
    /// and `refquat` of MJCF.
    pub reference: Frame,
    /// The part of the file to use, in SDF; `None` for the whole file.
    pub submesh: Option<Submesh>,
}

/// A part of a mesh file.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Submesh {
    /// Its name in the file.
    pub name: String,
    /// Whether it is moved so that the centre of its box is the origin.
    pub is_centered: bool,
}

impl MeshUse {
    /// A vertex of the file in the frame of the shape.
    pub fn placed(&self, vertex: DVec3) -> DVec3 {
        self.reference.inverse().apply(vertex) * DVec3::from_array(self.scale)
    }

    /// The greatest factor: lengths in the robot are at most this many times lengths in the mesh.
    pub fn stretch(&self) -> f64 {
        self.scale.iter().fold(0.0, |max: f64, factor| max.max(factor.abs()))
    }
}

/// A model in another file: attached in MJCF, included in SDF.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OtherModel {
    /// Its file or folder, as the description writes it.
    pub written: String,
    /// The line that names it.
    pub line: u32,
    /// Its file or folder, canonical; `None` if there is none.
    pub path: Option<PathBuf>,
}

/// A file that a description names by a path relative to its folder.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Reference {
    /// The path from the folder of the description, without `.`.
    pub path: PathBuf,
    /// The end of that path, as the description writes it.
    pub written: String,
    /// The file.
    pub file: PathBuf,
}

/// A change of a description.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "fields are named after their contents")]
pub enum Change {
    /// A collision gets these meshes, named as by [`Description::mesh_name`], at least one.
    Replace { link: usize, collision: usize, meshes: Vec<String> },
    /// Collisions are made from a visual: one for each mesh, or one with its primitive.
    FromVisual {
        link: usize,
        visual: usize,
        /// Names of the meshes; `None` for a primitive.
        meshes: Option<Vec<String>>,
    },
    /// The inertia of a link that states its mass is replaced.
    Inertia {
        link: usize,
        center: [f64; 3],
        /// Rows of the tensor about it, in the axes of the link.
        inertia: [[f64; 3]; 3],
    },
    /// Contacts of pairs of links are excluded, in MJCF, for bodies with names.
    Exclude { pairs: Vec<[usize; 2]>, comment: String },
    /// A collision is removed. In MJCF, a geom that is drawn, has mass or is named by another
    /// element stays, but no longer collides.
    Remove { link: usize, collision: usize },
}

impl Change {
    /// The link, the shape, and the meshes; `None` if no shape changes.
    pub(crate) fn parts<'a>(&'a self, links: &'a [Link]) -> Option<(&'a Link, &'a Shape, Option<&'a [String]>)> {
        Some(match self {
            Self::Inertia { .. } | Self::Exclude { .. } => return None,
            Self::Replace { link, collision, meshes } => {
                (&links[*link], &links[*link].collisions[*collision], Some(meshes))
            }
            Self::Remove { link, collision } => (&links[*link], &links[*link].collisions[*collision], None),
            Self::FromVisual { link, visual, meshes } => {
                (&links[*link], &links[*link].visuals[*visual], meshes.as_deref())
            }
        })
    }
}

impl Description {
    /// The file's path.
    pub fn path(&self) -> &Path {
        self.documents[0].path()
    }

    /// Folder of the new meshes, if only one will do: programs remove folders from their names.
    /// `target` is the folder of the edited description.
    pub fn mesh_folder(&self, target: &Path) -> Option<PathBuf> {
        self.mesh_names.only_folder.as_ref().map(|folder| target.join(folder))
    }

    /// The name of a mesh in the description, if that is written to the folder `target`; both paths
    /// are absolute. It is by package or model if others are, by the name that they use.
    ///
    /// # Errors
    /// There is no such name, for instance because the mesh is on another drive.
    pub fn mesh_name(&self, mesh: &Path, target: &Path) -> Result<String, RobotError> {
        let names = &self.mesh_names;
        let known = names.packages.iter().find_map(|package| package.name_of(mesh, target));
        let in_package = known.or_else(|| {
            let package = NamedPackage::above(names.packages.first()?.scheme, mesh)?;
            // The mark of a model may be a copy that a bake wrote: the first bake writes the same.
            let is_copy = package.scheme == Scheme::Model && package.folder == target;
            (!is_copy).then(|| package.name_of(mesh, target)).flatten()
        });
        let name = in_package.or_else(|| relative(mesh, &target.join(&names.folder)));
        name.ok_or_else(|| {
            let message =
                format!("{} has no path relative to {}; write both to one drive", mesh.display(), target.display());
            RobotError::rejected(self.path(), None, message)
        })
    }
}

/// A finite number.
pub(crate) fn number(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|number: &f64| number.is_finite())
}

pub(crate) fn numbers(text: &str) -> Option<Vec<f64>> {
    let numbers = text.split_whitespace().map(number);
    numbers.collect()
}

pub(crate) fn triple(text: &str) -> Option<[f64; 3]> {
    numbers(text)?.try_into().ok()
}

/// Three factors, or one for all axes, not 0.
pub(crate) fn scale(text: Option<&str>) -> Result<[f64; 3], String> {
    let Some(text) = text else { return Ok([1.0; 3]) };
    let factors = triple(text).or_else(|| text.trim().parse().ok().map(|factor: f64| [factor; 3]));
    let factors = factors.filter(|factors| factors.iter().all(|factor| factor.is_finite() && *factor != 0.0));
    factors.ok_or_else(|| format!("the scale `{text}` is not three numbers other than 0; correct it"))
}

/// A mesh with this scale. `find` returns its file.
pub(crate) fn mesh_use(
    written: &str,
    scale_text: Option<&str>,
    find: impl FnOnce(&str) -> Result<PathBuf, Unresolved>,
) -> MeshUse {
    let (scale, file) = match scale(scale_text) {
        Ok(scale) => (scale, find(written)),
        Err(fault) => ([1.0; 3], Err(Unresolved::Failed(fault))),
    };
    MeshUse { written: written.to_owned(), file, scale, reference: Frame::IDENTITY, submesh: None }
}

/// A reference to an existing file by a path relative to `folder`, of a description in `root`.
pub(crate) fn reference(written: &str, places: &Places, folder: &Path, root: &Path) -> Option<Reference> {
    let is_relative = !written.contains("://") && !Path::new(written).has_root() && !written.trim().is_empty();
    let file = is_relative.then(|| places.resolve(written, folder).ok()).flatten()?;
    let absolute = |path: &Path| std::path::absolute(path).ok();
    let below = relative(&absolute(&folder.join(written.trim()))?, &absolute(root)?)?;
    Some(Reference { path: below.into(), written: written.to_owned(), file })
}

pub(crate) fn packages_of(links: &[Link]) -> Vec<NamedPackage> {
    let mut packages: Vec<NamedPackage> = Vec::new();
    let meshes = links.iter().flat_map(Link::meshes).filter(|mesh| Scheme::split(&mesh.written).is_some());
    for mesh in meshes {
        let package = mesh.file.as_ref().ok().and_then(|file| NamedPackage::of(&mesh.written, file));
        packages.extend(package.filter(|package| !packages.contains(package)));
    }
    packages
}
