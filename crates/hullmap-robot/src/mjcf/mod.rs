//! MJCF: bodies with geoms, which name meshes of the assets.
//!
//! A geom collides unless `contype` and `conaffinity` are both 0. In many models it is drawn, and
//! gives the body its mass, too. So a geom that is drawn, or whose mass counts, gets a copy that
//! does neither collide nor have a name: model and masses stay what they are, to the bit.
//!
//! # Reference
//! <https://mujoco.readthedocs.io/en/stable/XMLreference.html>

mod classes;
mod edits;
pub(crate) mod model;
mod tree;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::description::{
    Description, Format, Geometry, Link, MeshNames, Reference, Shape, folder_of, mesh_use, reference,
};
use crate::document::Document;
use crate::error::RobotError;
use crate::places::Places;
use classes::Classes;
pub(crate) use edits::edits;
use model::{Geom, Model};
use tree::{Element, Tree};

/// Groups below this one are drawn unless the user hides them.
const FIRST_HIDDEN_GROUP: i32 = 3;

/// Elements inside a body that hold geoms of the same body.
const TRANSPARENT: [&str; 2] = ["frame", "replicate"];

/// Attributes that name geoms.
const NAMES_OF_GEOMS: [&str; 4] = ["geom", "geom1", "geom2", "objname"];

/// A mesh asset.
struct Asset<'a> {
    element: Element<'a>,
    /// `None` for a mesh without a file.
    file: Option<&'a str>,
}

/// Settings of `compiler`, over all files.
struct Compiler<'a>(BTreeMap<&'a str, &'a str>);

impl<'a> Compiler<'a> {
    fn read(tree: &Tree<'a>) -> Self {
        let compilers = tree.children(tree.root()).into_iter().filter(|element| element.name() == "compiler");
        let stated = compilers.flat_map(|compiler| compiler.node.attributes().map(|own| (own.name(), own.value())));
        Self(stated.collect())
    }

    /// The folder of these assets.
    fn folder(&self, key: &str) -> &'a str {
        self.0.get(key).or(self.0.get("assetdir")).copied().unwrap_or_default()
    }

    fn is(&self, key: &str, value: &str) -> bool {
        self.0.get(key) == Some(&value)
    }
}

/// Finds the bodies of a model.
///
/// # Errors
/// A file is missing, invalid, or included twice, or names are used twice.
pub(crate) fn read(document: Document, places: &Places) -> Result<Description, RobotError> {
    let (documents, includes) = tree::load(document, places)?;
    let parsed: Vec<roxmltree::Document> = documents.iter().map(Document::parse).collect::<Result<_, _>>()?;
    let tree = Tree { parsed: &parsed, includes: &includes };
    let compiler = Compiler::read(&tree);
    let strips = compiler.is("strippath", "true");
    let folder = folder_of(documents[0].path()).to_owned();
    let mesh_folder = folder.join(compiler.folder("meshdir"));
    let reader = Reader {
        documents: &documents,
        classes: Classes::read(&tree),
        assets: assets(&tree, &documents)?,
        pinned: pinned(&tree),
        compiler: &compiler,
        places,
        mesh_folder: &mesh_folder,
        strips,
        tree,
    };
    let (links, geoms) = reader.bodies()?;
    let references = references(&reader, &folder);
    let notes = reader.notes();
    let mesh_names = MeshNames { scheme: None, folder: compiler.folder("meshdir").to_owned(), strips };
    drop(reader);
    drop(compiler);
    drop(parsed);
    let mjcf = Some(Model { includes, geoms });
    Ok(Description { format: Format::Mjcf, documents, links, references, notes, mesh_names, mjcf })
}

/// The meshes of the assets, by name.
fn assets<'a>(tree: &Tree<'a>, documents: &[Document]) -> Result<BTreeMap<String, Asset<'a>>, RobotError> {
    let mut assets: BTreeMap<String, Asset> = BTreeMap::new();
    for element in tree.section("asset").into_iter().filter(|element| element.name() == "mesh") {
        let file = element.node.attribute("file");
        let stem = || Some(Path::new(file?).file_stem()?.to_string_lossy().into_owned());
        let Some(name) = element.node.attribute("name").map(str::to_owned).or_else(stem) else { continue };
        if let Some(first) = assets.get(&name) {
            let document = &documents[first.element.document];
            let line = document.line(first.element.node.range().start);
            let message =
                format!("mesh `{name}` exists already, at {}:{line}; rename one of them", document.path().display());
            return Err(documents[element.document].error(element.node.range().start, message));
        }
        assets.insert(name, Asset { element, file });
    }
    Ok(assets)
}

/// The geoms that other elements name, each with the element that does.
fn pinned(tree: &Tree) -> BTreeMap<String, String> {
    let named = tree.all().flat_map(|element| {
        let attributes = element.node.attributes().filter(|own| NAMES_OF_GEOMS.contains(&own.name()));
        attributes.map(move |own| (own.value().to_owned(), element.name().to_owned()))
    });
    named.collect()
}

/// Reads bodies and geoms.
struct Reader<'a> {
    documents: &'a [Document],
    tree: Tree<'a>,
    classes: Classes,
    assets: BTreeMap<String, Asset<'a>>,
    pinned: BTreeMap<String, String>,
    compiler: &'a Compiler<'a>,
    places: &'a Places,
    mesh_folder: &'a Path,
    strips: bool,
}

/// An element, and the class that it inherits.
type Inherited<'a, 'c> = (Element<'a>, Option<&'c str>);

type Geoms = BTreeMap<(usize, usize), Geom>;

impl<'a> Reader<'a> {
    fn bodies(&self) -> Result<(Vec<Link>, Geoms), RobotError> {
        let (mut links, mut geoms) = (Vec::new(), Geoms::new());
        let mut names: BTreeMap<String, u32> = BTreeMap::new();
        let worlds = self.tree.children(self.tree.root()).into_iter().filter(|element| element.name() == "worldbody");
        let mut waiting: Vec<(Element, Option<&str>)> = worlds.map(|world| (world, None)).collect();
        waiting.reverse();
        while let Some((body, inherited)) = waiting.pop() {
            let childclass = body.node.attribute("childclass").or(inherited);
            let [own, bodies] = self.contents(body, childclass);
            waiting.extend(bodies.into_iter().rev());
            let document = &self.documents[body.document];
            let line = document.line(body.node.range().start);
            let is_world = body.name() == "worldbody";
            let unnamed = || if is_world { "world".to_owned() } else { format!("body in line {line}") };
            let name = body.node.attribute("name").map_or_else(unnamed, str::to_owned);
            if let Some(first) = names.insert(name.clone(), line).filter(|_| !is_world) {
                let message = format!("body `{name}` exists already, in line {first}; rename one of them");
                return Err(document.error(body.node.range().start, message));
            }
            let has_inertial = self.tree.children(body).iter().any(|child| child.name() == "inertial");
            let counts_mass = !is_world
                && (self.compiler.is("inertiafromgeom", "true")
                    || !has_inertial && !self.compiler.is("inertiafromgeom", "false"));
            let (mut collisions, mut visuals) = (Vec::new(), Vec::new());
            for (geom, childclass) in own {
                let (shape, facts, collides) = self.geom(geom, childclass, counts_mass);
                geoms.insert((geom.document, shape.at), facts);
                if collides { collisions.push(shape) } else { visuals.push(shape) }
            }
            let at = body.node.range().start;
            links.push(Link {
                name,
                document: body.document,
                line,
                at,
                collisions,
                visuals,
                takes_visuals: !is_world,
                mass: None,
            });
        }
        Ok((links, geoms))
    }

    /// The geoms of a body, and the bodies in it, each with its inherited class.
    fn contents<'c>(&self, body: Element<'a>, childclass: Option<&'c str>) -> [Vec<Inherited<'a, 'c>>; 2]
    where
        'a: 'c,
    {
        let (mut geoms, mut bodies) = (Vec::new(), Vec::new());
        let mut waiting = vec![(body, childclass)];
        while let Some((parent, childclass)) = waiting.pop() {
            for child in self.tree.children(parent) {
                match child.name() {
                    "geom" => geoms.push((child, childclass)),
                    "body" => bodies.push((child, childclass)),
                    name if TRANSPARENT.contains(&name) => {
                        waiting.push((child, child.node.attribute("childclass").or(childclass)));
                    }
                    _ => {}
                }
            }
        }
        [geoms, bodies]
    }

    /// A geom, and whether it collides.
    fn geom(&self, geom: Element<'a>, childclass: Option<&str>, counts_mass: bool) -> (Shape, Geom, bool) {
        let get = |name: &str| self.classes.get(&geom, childclass, name);
        let number = |name: &str, default: i32| get(name).and_then(|text| text.trim().parse().ok()).unwrap_or(default);
        let name = geom.node.attribute("name").unwrap_or_default().to_owned();
        let pinned = self.pinned.get(&name).filter(|_| !name.is_empty());
        let is_paired = pinned.is_some_and(|by| by == "pair");
        let collides = number("contype", 1) != 0 || number("conaffinity", 1) != 0 || is_paired;
        let mesh = get("mesh").and_then(|name| Some((name, self.assets.get(name)?)));
        let geometry = match (get("type").unwrap_or("sphere"), mesh) {
            ("mesh", Some((_, asset))) => self.mesh(asset),
            ("mesh", None) => {
                Geometry::Other(format!("its mesh `{}` is not among the assets", get("mesh").unwrap_or_default()))
            }
            (kind @ ("plane" | "hfield" | "sdf"), _) => Geometry::Other(format!("`{kind}` is not a mesh")),
            (kind, _) => Geometry::Primitive(kind.to_owned()),
        };
        let has_mass = match get("mass") {
            Some(mass) => mass.trim().parse() != Ok(0.0),
            None => get("density").is_none_or(|density| density.trim().parse() != Ok(0.0)),
        };
        let is_drawn = number("group", 0) < FIRST_HIDDEN_GROUP;
        let document = &self.documents[geom.document];
        let at = geom.node.range().start;
        let stays_single = pinned.map(|by| format!("an element `{by}` names the geom"));
        let shape =
            Shape { name, document: geom.document, line: document.line(at), geometry, pose: None, stays_single, at };
        let asset = mesh.map(|(_, asset)| (asset.element.document, asset.element.node.range().start));
        (shape, Geom { keeps_copy: is_drawn || counts_mass && has_mass, asset }, collides)
    }

    fn mesh(&self, asset: &Asset) -> Geometry {
        let Some(file) = asset.file else {
            return Geometry::Other("its mesh is written in the model; save it as a file".to_owned());
        };
        let scale = self.classes.get(&asset.element, None, "scale");
        let name =
            if self.strips { Path::new(file).file_name().and_then(|name| name.to_str()).unwrap_or(file) } else { file };
        let mut mesh = mesh_use(name, scale, self.places, self.mesh_folder);
        mesh.written = file.to_owned();
        Geometry::Mesh(mesh)
    }

    fn notes(&self) -> Vec<String> {
        let is_other = |element: &Element| ["attach", "flexcomp"].contains(&element.name());
        let note = |element: Element| {
            let line = self.documents[element.document].line(element.node.range().start);
            format!("line {line}: `{}` keeps its collisions", element.name())
        };
        self.tree.all().filter(is_other).map(note).collect()
    }
}

/// Files that the model names by relative paths.
fn references(reader: &Reader, folder: &Path) -> Vec<Reference> {
    let mut found = BTreeSet::new();
    for element in reader.tree.all() {
        let folders: &[&str] = match element.name() {
            "mesh" | "skin" | "hfield" => &["meshdir", ""],
            "texture" => &["texturedir", ""],
            _ => &[""],
        };
        let named = element.node.attributes().filter(|own| own.name().starts_with("file"));
        for name in named.map(|own| own.value()) {
            let within = |key: &&str| if key.is_empty() { "" } else { reader.compiler.folder(key) };
            let path = |within: &str| Path::new(within).join(name).to_string_lossy().replace('\\', "/");
            let reference =
                folders.iter().map(within).find_map(|within| reference(&path(within), reader.places, folder));
            found.extend(reference.map(|reference| Reference { written: name.to_owned(), ..reference }));
        }
    }
    found.into_iter().collect()
}
