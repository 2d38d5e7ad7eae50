//! MJCF: bodies with geoms, which name meshes of the assets.
//!
//! A geom collides unless `contype` and `conaffinity` are both 0. In many models it is drawn, and
//! gives the body its mass, too. Then it gets a copy that does not collide and has no name, so that
//! look and masses stay the same, to the bit.
//!
//! # Reference
//! <https://mujoco.readthedocs.io/en/stable/XMLreference.html>

mod attached;
mod classes;
pub(crate) mod compiler;
mod contacts;
mod edits;
mod joints;
pub(crate) mod model;
mod pose;
mod source;
mod tree;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::slice;
use std::sync::Arc;

use crate::chain::{Chain, Joint};
use crate::description::{
    Description, Format, Geometry, Link, MeshNames, OtherModel, Reference, Shape, Unread, mesh_use, numbers, reference,
};
use crate::document::Document;
use crate::error::RobotError;
use crate::frame::Frame;
use crate::places::{Places, Unresolved, folder_of};
use crate::primitive::{NamedPrimitive, Primitive};
use crate::urdf;
use classes::Classes;
use compiler::{Compiler, Start};
pub(crate) use edits::edits;
use model::{Geom, Model};
use pose::between;
use source::Source;
use tree::{Element, Tree};

/// Groups below this one are drawn unless the user hides them.
const FIRST_HIDDEN_GROUP: i32 = 3;

/// Elements inside a body that hold geoms of the same body.
const TRANSPARENT: [&str; 2] = ["frame", "replicate"];

/// Elements that stand for bodies and geoms, and are not read.
const UNREAD: [&str; 4] = ["attach", "composite", "flexcomp", "flex"];

const NAMES_OF_GEOMS: [&str; 4] = ["geom", "geom1", "geom2", "objname"];

struct Asset<'a> {
    element: Element<'a>,
    source: Source<'a>,
}

/// Reads a model, with references to the files that attached models need.
pub(crate) fn read(document: Document, places: &Places) -> Result<Description, RobotError> {
    let (mut description, attached) = read_one(document, places)?;
    let read_other = |path: &Path| {
        let document = Document::read(path)?;
        let is_urdf = document.parse()?.root_element().has_tag_name("robot");
        if is_urdf { Ok((urdf::read(document, places)?, Vec::new())) } else { read_one(document, places) }
    };
    attached::add_references(&mut description, attached, read_other);
    Ok(description)
}

fn read_one(document: Document, places: &Places) -> Result<(Description, Vec<Reference>), RobotError> {
    let (documents, includes) = tree::load(document, places)?;
    let parsed: Vec<roxmltree::Document> = documents.iter().map(Document::parse).collect::<Result<_, _>>()?;
    let tree = Tree { parsed: &parsed, includes: &includes };
    let compilers = tree.children(tree.root()).into_iter().filter(|element| element.name() == "compiler");
    let compiler = Compiler::new(compilers.map(|compiler| compiler.node));
    let reader = Reader {
        documents: &documents,
        classes: Classes::read(&tree),
        assets: assets(&tree, &documents)?,
        pinned: pinned(&tree),
        paired: contacts::paired_geoms(&tree),
        compiler: &compiler,
        places,
        tree,
    };
    let (links, geoms, chain, mut warnings) = reader.bodies()?;
    let (references, attached) = references(&reader);
    let (notes, others) = (reader.notes(), reader.others());
    warnings.extend(reader.unknown_classes());
    let name = reader.tree.root().node.attribute("model").unwrap_or_default().to_owned();
    let (contacts, unknown) = contacts::contacts(&reader.tree, &links);
    let unread = reader.unread(unknown);
    let meshes = compiler.opened("mesh").unwrap_or_default().path;
    // Names of an included file must be found in both folders.
    let assets_in_model = !compiler.strips() && compiler.probed("mesh").path != meshes;
    let only_folder = compiler.strips().then(|| meshes.to_owned());
    let mesh_names = MeshNames { packages: Vec::new(), folder: meshes.to_owned(), only_folder };
    drop(reader);
    drop(compiler);
    drop(parsed);
    let mjcf = Some(Model { includes, geoms, assets_in_model });
    let chain = chain.without_circular_couplings();
    let description = Description {
        format: Format::Mjcf,
        name,
        documents,
        links,
        references,
        notes,
        others,
        warnings,
        chain,
        contacts,
        unread,
        mesh_names,
        mjcf,
    };
    Ok((description, attached))
}

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
        let source = file.map_or_else(|| Source::without_file(element.node, &name), Source::File);
        assets.insert(name, Asset { element, source });
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

struct Reader<'a> {
    documents: &'a [Document],
    tree: Tree<'a>,
    classes: Classes,
    assets: BTreeMap<String, Asset<'a>>,
    pinned: BTreeMap<String, String>,
    paired: BTreeSet<&'a str>,
    compiler: &'a Compiler<'a>,
    places: &'a Places,
}

#[derive(Clone, Copy)]
struct Inside<'a, 'c> {
    element: Element<'a>,
    childclass: Option<&'c str>,
    /// The frame of the elements `frame` around it, in the frame of the body.
    frame: Frame,
}

#[derive(Default)]
struct Contents<'a, 'c> {
    geoms: Vec<Inside<'a, 'c>>,
    joints: Vec<Inside<'a, 'c>>,
    bodies: Vec<Inside<'a, 'c>>,
}

type Geoms = BTreeMap<(usize, usize), Geom>;

impl<'a> Reader<'a> {
    fn bodies(&self) -> Result<(Vec<Link>, Geoms, Chain, Vec<String>), RobotError> {
        let (mut links, mut geoms, mut warnings) = (Vec::new(), Geoms::new(), Vec::new());
        let (mut placed, mut mocap, mut joints) = (Vec::new(), Vec::new(), Vec::new());
        let mut names: BTreeMap<String, u32> = BTreeMap::new();
        let worlds = self.tree.children(self.tree.root()).into_iter().filter(|element| element.name() == "worldbody");
        let worlds: Vec<Element> = worlds.collect();
        let inside = |element| Inside { element, childclass: None, frame: Frame::IDENTITY };
        // All `worldbody` elements are one body.
        let mut waiting: Vec<(Inside, Option<usize>)> =
            worlds.first().map(|&first| (inside(first), None)).into_iter().collect();
        while let Some((body, parent)) = waiting.pop() {
            let index = links.len();
            let childclass = body.element.node.attribute("childclass").or(body.childclass);
            let elements = if parent.is_none() { &worlds } else { slice::from_ref(&body.element) };
            let own = self.contents(elements, childclass);
            waiting.extend(own.bodies.into_iter().rev().map(|body| (body, Some(index))));
            warnings.extend(own.geoms.iter().filter_map(|geom| self.unknown_mesh(geom)));
            let link = self.link(body.element, own.geoms, &mut geoms, &mut names)?;
            let rest = self.compiler.angles().frame(|name| body.element.node.attribute(name)).unwrap_or_else(|| {
                warnings.push(format!(
                    "{}: the pose of body `{}` is invalid, so it is taken as 0; correct it",
                    self.place(body.element),
                    link.name
                ));
                Frame::IDENTITY
            });
            placed.push((parent, body.frame * rest));
            mocap.extend((body.element.node.attribute("mocap") == Some("true")).then_some(index));
            joints.extend(own.joints.into_iter().map(|joint| self.joint(index, joint)));
            links.push(link);
        }
        let mut chain = Chain::new(links.len());
        for (index, (parent, rest)) in placed.into_iter().enumerate() {
            match parent {
                // A body has one parent, which comes before it.
                Some(parent) => chain.attach(index, parent, rest).unwrap_or_default(),
                None => chain.links[index].is_world = true,
            }
        }
        mocap.into_iter().for_each(|link| chain.links[link].is_mocap = true);
        chain.joints = joints;
        joints::couple(&self.tree, &mut chain);
        Ok((links, geoms, chain, warnings))
    }

    fn place(&self, element: Element) -> String {
        let document = &self.documents[element.document];
        format!("{}:{}", document.path().display(), document.line(element.node.range().start))
    }

    fn unknown_mesh(&self, geom: &Inside) -> Option<String> {
        let get = |name| self.classes.get(&geom.element, geom.childclass, name);
        let place = self.place(geom.element);
        match get("mesh") {
            Some(mesh) if self.assets.contains_key(mesh) => None,
            Some(mesh) => Some(format!(
                "{place}: no mesh `{mesh}` is among the assets, and MuJoCo rejects the model; add it, or correct the name"
            )),
            None => (get("type") == Some("mesh"))
                .then(|| format!("{place}: this geom names no mesh, and MuJoCo rejects the model; add mesh=\"…\"")),
        }
    }

    fn unknown_classes(&self) -> Vec<String> {
        let mut seen = BTreeSet::new();
        let named = self.tree.all().filter(|element| element.name() != "default").flat_map(|element| {
            let classes = ["class", "childclass"].into_iter().filter_map(move |key| element.node.attribute(key));
            classes.map(move |class| (element, class))
        });
        let unknown = named.filter(|(_, class)| !self.classes.has(class) && seen.insert(*class));
        let warning = |(element, class)| {
            let place = self.place(element);
            format!(
                "{place}: no default class `{class}` exists, and MuJoCo rejects the model; add it, or correct the name"
            )
        };
        unknown.map(warning).collect()
    }

    /// A body as a link. Adds the facts about its geoms that edits need.
    fn link(
        &self,
        body: Element<'a>,
        own: Vec<Inside>,
        geoms: &mut Geoms,
        names: &mut BTreeMap<String, u32>,
    ) -> Result<Link, RobotError> {
        let document = &self.documents[body.document];
        let at = body.node.range().start;
        let line = document.line(at);
        let is_world = body.name() == "worldbody";
        let unnamed = || match format!("body in line {line}") {
            _ if is_world => "world".to_owned(),
            name if names.contains_key(&name) => format!("body {} in line {line}", names.len()),
            name => name,
        };
        let name = body.node.attribute("name").map_or_else(unnamed, str::to_owned);
        if let Some(first) = names.insert(name.clone(), line) {
            let message = format!("body `{name}` exists already, in line {first}; rename one of them");
            return Err(document.error(at, message));
        }
        let inertial = self.tree.children(body).into_iter().find(|child| child.name() == "inertial");
        let has_inertial = inertial.is_some();
        let counts_mass = !is_world
            && (self.compiler.is("inertiafromgeom", "true")
                || !has_inertial && !self.compiler.is("inertiafromgeom", "false"));
        let (mut collisions, mut visuals) = (Vec::new(), Vec::new());
        for geom in own {
            let (shape, facts, collides) = self.geom(geom, counts_mass);
            geoms.insert((geom.element.document, shape.at), facts);
            if collides { collisions.push(shape) } else { visuals.push(shape) }
        }
        let mass = inertial.and_then(|own| own.node.attribute("mass")?.trim().parse().ok());
        let mass = mass.filter(|mass: &f64| !counts_mass && *mass > 0.0 && mass.is_finite());
        let takes_visuals = !is_world;
        Ok(Link { name, document: body.document, line, at, collisions, visuals, takes_visuals, mass })
    }

    fn joint(&self, link: usize, joint: Inside) -> Joint {
        let name = joint.element.node.attribute("name").unwrap_or_default();
        if joint.element.name() == "freejoint" {
            let is_free = |name: &str| (name == "type").then_some("free");
            return joints::joint(link, name, joint.frame, self.compiler.angles(), false, is_free);
        }
        let auto_limits = !self.compiler.is("autolimits", "false");
        let get = |name: &str| self.classes.get(&joint.element, joint.childclass, name);
        joints::joint(link, name, joint.frame, self.compiler.angles(), auto_limits, get)
    }

    /// The geoms, joints and bodies of the elements of a body, in the order of the file.
    fn contents<'c>(&self, elements: &[Element<'a>], childclass: Option<&'c str>) -> Contents<'a, 'c>
    where
        'a: 'c,
    {
        let mut found = Contents::default();
        let children = |parent: Inside<'a, 'c>| {
            let children = self.tree.children(parent.element).into_iter().rev();
            children.map(move |element| Inside { element, ..parent })
        };
        let outer = elements.iter().rev().map(|&element| Inside { element, childclass, frame: Frame::IDENTITY });
        let mut waiting: Vec<Inside> = outer.flat_map(children).collect();
        while let Some(own) = waiting.pop() {
            match own.element.name() {
                "geom" => found.geoms.push(own),
                "joint" | "freejoint" => found.joints.push(own),
                "body" => found.bodies.push(own),
                name if TRANSPARENT.contains(&name) => {
                    let attribute = |name: &str| own.element.node.attribute(name);
                    // The first copy of `replicate` is where the element is.
                    let pose = if name == "frame" { self.compiler.angles().frame(attribute) } else { None };
                    let frame = own.frame * pose.unwrap_or(Frame::IDENTITY);
                    let childclass = attribute("childclass").or(own.childclass);
                    waiting.extend(children(Inside { childclass, frame, ..own }));
                }
                _ => {}
            }
        }
        found
    }

    fn geom(&self, geom: Inside<'a, '_>, counts_mass: bool) -> (Shape, Geom, bool) {
        let Inside { element: geom, childclass, frame } = geom;
        let get = |name: &str| self.classes.get(&geom, childclass, name);
        let number = |name: &str, default: i32| get(name).and_then(|text| text.trim().parse().ok()).unwrap_or(default);
        let name = geom.node.attribute("name").unwrap_or_default().to_owned();
        let pinned = self.pinned.get(&name).filter(|_| !name.is_empty());
        let contact_bits = [number("contype", 1), number("conaffinity", 1)];
        let collides = contact_bits != [0, 0] || self.paired.contains(name.as_str());
        let mesh = get("mesh").and_then(|name| Some((name, self.assets.get(name)?)));
        let ends = get("fromto").and_then(between);
        let geometry = match (get("type").unwrap_or("sphere"), mesh) {
            ("mesh", Some((_, asset))) => self.mesh(asset),
            ("mesh", None) => {
                Geometry::Other(format!("its mesh `{}` is not among the assets", get("mesh").unwrap_or_default()))
            }
            (kind @ ("plane" | "hfield" | "sdf"), _) => Geometry::Other(format!("`{kind}` is not a mesh")),
            (kind, Some(_)) => Geometry::Other(format!("the `{kind}` is fitted to a mesh by MuJoCo; state its size")),
            (kind, None) => {
                let size = get("size").and_then(numbers).unwrap_or_default();
                let shape = read_primitive(kind, size, ends.map(|(_, half)| half));
                Geometry::Primitive(NamedPrimitive { name: kind.to_owned(), shape })
            }
        };
        let has_mass = match get("mass") {
            Some(mass) => mass.trim().parse() != Ok(0.0),
            None => get("density").is_none_or(|density| density.trim().parse() != Ok(0.0)),
        };
        let is_drawn = number("group", 0) < FIRST_HIDDEN_GROUP;
        let at = geom.node.range().start;
        let own = ends.map(|(own, _)| own).or_else(|| self.compiler.angles().frame(get));
        let is_named = pinned.is_some();
        let is_hull =
            mesh.is_some_and(|(_, asset)| matches!(&asset.source, Source::Inline(own) if own.triangles.is_empty()));
        let only_hull = is_hull.then(|| "its mesh is the hull of points".to_owned());
        let shape = Shape {
            name,
            document: geom.document,
            line: self.documents[geom.document].line(at),
            geometry,
            pose: own.map(|own| frame * own),
            contact_bits,
            is_drawn,
            stays_single: pinned.map(|by| format!("an element `{by}` names the geom")).or(only_hull),
            at,
        };
        let asset = mesh.map(|(_, asset)| (asset.element.document, asset.element.node.range().start));
        (shape, Geom { keeps_copy: is_drawn || counts_mass && has_mass, is_named, asset }, collides)
    }

    fn mesh(&self, asset: &Asset) -> Geometry {
        let scale = self.classes.get(&asset.element, None, "scale");
        let mut mesh = match &asset.source {
            Source::File(file) => {
                mesh_use(file, scale, |file| self.places.find(self.start(asset.element, file).name()))
            }
            Source::Inline(own) => mesh_use(&own.name, scale, |_| Err(Unresolved::Inline(Arc::clone(own)))),
            Source::Invalid(cause) => mesh_use("", scale, |_| Err(Unresolved::Failed(cause.clone()))),
            Source::Other => return Geometry::Other("its mesh has neither a file nor vertices".to_owned()),
        };
        let reference = |name: &str| match name {
            "pos" => self.classes.get(&asset.element, None, "refpos"),
            "quat" => self.classes.get(&asset.element, None, "refquat"),
            _ => None,
        };
        mesh.reference = self.compiler.angles().frame(reference).unwrap_or(Frame::IDENTITY);
        Geometry::Mesh(mesh)
    }

    /// Elements with geometry that is not among the links. `pairs` name geoms that are not.
    fn unread(&self, pairs: Vec<Element>) -> Vec<Unread> {
        let reason = |element: &Element| match element.name() {
            "replicate" => Some("only its first copy is read"),
            name if UNREAD.contains(&name) => Some("it is not read; write its bodies into this model"),
            _ => None,
        };
        let found = self.tree.all().filter_map(|element| Some((element, reason(&element)?)));
        let found = found.chain(pairs.into_iter().map(|pair| (pair, "it names a geom that is not read")));
        let unread = |(element, reason): (Element, &'static str)| {
            let line = self.line(element);
            Unread { document: element.document, line, element: format!("`{}`", element.name()), reason }
        };
        found.map(unread).collect()
    }

    fn start<'n>(&self, of: Element, name: &'n str) -> Start<'n> {
        let folder = |document: usize| folder_of(self.documents[document].path());
        let included = Some(folder(of.document)).filter(|_| of.document != 0);
        self.compiler.start(of.name(), name, (folder(0), included), self.places)
    }

    fn line(&self, element: Element) -> u32 {
        self.documents[element.document].line(element.node.range().start)
    }

    fn notes(&self) -> Vec<String> {
        let is_whole = |own: &Element| own.name() == "attach" && own.node.attribute("model").is_none();
        let kept = self.tree.all().filter(|own| is_whole(own) || own.name() == "flexcomp");
        kept.map(|own| format!("line {}: `{}` keeps its collisions", self.line(own), own.name())).collect()
    }

    /// The models among its assets.
    fn others(&self) -> Vec<OtherModel> {
        let models = self.tree.section("asset").into_iter().filter(|own| own.name() == "model");
        let other = |own: Element| {
            let written = own.node.attribute("file")?;
            let start = self.start(own, written);
            let path = self.places.resolve(start.name, &start.folder).ok().and_then(|file| file.canonicalize().ok());
            Some(OtherModel { written: written.to_owned(), line: self.line(own), path })
        };
        models.filter_map(other).collect()
    }
}

/// The primitive of a geom. `half_length` is half of the distance of its two points, if given.
fn read_primitive(kind: &str, mut size: Vec<f64>, half_length: Option<f64>) -> Option<Primitive> {
    if let (Some(half_length), Some(&radius)) = (half_length, size.first()) {
        let is_long = matches!(kind, "box" | "ellipsoid");
        size = if is_long { vec![radius, radius, half_length] } else { vec![radius, half_length] };
    }
    Primitive::new(kind, &size)
}

/// Files that the model names by relative paths: all of them, and the files of attached models.
fn references(reader: &Reader) -> (Vec<Reference>, Vec<Reference>) {
    let root = folder_of(reader.documents[0].path());
    let (mut found, mut attached) = (BTreeSet::new(), BTreeSet::new());
    for element in reader.tree.all() {
        let probed = reader.compiler.probed(element.name()).path;
        let named = element.node.attributes().filter(|own| own.name().starts_with("file"));
        for written in named.map(|own| own.value()) {
            let start = reader.start(element, written);
            let opened = reference(start.name, reader.places, &start.folder, root);
            if element.name() == "model" {
                attached.extend(opened.clone());
            }
            // In an included file, the file that MuJoCo looks for first decides which one it opens.
            let probed = (element.document != 0).then(|| reference(written, reader.places, &root.join(probed), root));
            let exists = opened.into_iter().chain(probed.flatten());
            found.extend(exists.map(|own| Reference { written: written.to_owned(), ..own }));
        }
    }
    (found.into_iter().collect(), attached.into_iter().collect())
}
