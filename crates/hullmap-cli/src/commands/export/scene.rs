//! `bake export --into`: colliders below the nodes of a glTF file.
//!
//! A hull belongs to the node with the name of its object. The hull of a whole file belongs to its
//! only node, or to the scene. A node with hulls is a body, unless a node above it is one.
//!
//! Unreal finds collision parts by their names, so hulls are ordinary meshes in the frame of their
//! node, named after its mesh. In an OBJ file, they are groups after the others.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};
use hullmap::{MassSource, Pack};
use hullmap_bake::PointSet;
use hullmap_geometry::number::rounded;
use hullmap_import::{
    self as import, ImportOptions, Limits, ReadError, SceneObject, SourceFile, Split, UpAxis, scene_objects,
};
use serde::Deserialize;

use crate::args::export::{ExportArgs, Target};
use crate::scene::colliders::{self, Collider, Form, Motion};
use crate::scene::container::GltfFile;
use crate::terminal;
use hullmap_pipeline::mesh_file::body::{Body, DENSITY, counts};
use hullmap_pipeline::mesh_file::names::{self, NAMES_IN_MESSAGE};
use hullmap_pipeline::mesh_file::obj;
use hullmap_pipeline::mesh_file::seal::{SEAL, sealed};
use hullmap_pipeline::options::BuildOptions;
use hullmap_pipeline::outcome::Failure;
use hullmap_pipeline::pack_file::folder_of;
use hullmap_pipeline::principal_axes::principal_axes;
use hullmap_pipeline::source::Recorded;

/// Tolerance within which a scale counts as 1.
const UNSCALED: f64 = 1e-4;

pub struct Added<'a> {
    pub args: &'a ExportArgs,
    pub path: &'a Path,
    pub pack: &'a Pack,
    pub indices: &'a [usize],
}

fn form(args: &ExportArgs) -> Form {
    Form {
        khr: matches!(args.target, Some(Target::KhrPhysics | Target::Both)).then_some(args.draft),
        is_omi: matches!(args.target, Some(Target::Omi | Target::Both | Target::Godot)),
        is_visible: args.is_visible || args.target == Some(Target::Unreal),
        is_in_node: args.target == Some(Target::Unreal),
    }
}

pub fn alone(args: &ExportArgs, bodies: Vec<Body>) -> Result<Vec<u8>, String> {
    let at_root = |body| Collider { body, mesh_name: None, node: None, pack_in_node: DAffine3::IDENTITY };
    let colliders: Vec<Collider> = bodies.into_iter().map(at_root).collect();
    colliders::add(&GltfFile::empty(), &colliders, &[], &form(args))
}

impl Added<'_> {
    /// The file with the hulls, and their numbers.
    pub fn file(&self, into: &Path, bodies: Vec<Body>) -> Result<(Vec<u8>, [usize; 3]), Failure> {
        let form = form(self.args);
        let shown = into.display();
        let fault = |message: String| Failure::rejected(format!("{shown}: {message}"));
        let source = import::read(&shown.to_string(), into, &Limits::DEFAULT).map_err(|error| match error {
            ReadError::Io(error) => Failure::usage(format!("--into {shown}: cannot read: {error}; check the file")),
            ReadError::Import(error) => Failure::rejected(error.to_string()),
        })?;
        let recorded = Recorded::from_pack(self.pack);
        if Path::new(recorded.path).file_name() == into.file_name() && source.hash != recorded.hash {
            terminal::warning(format_args!(
                "{shown}: has changed since {} was baked; bake it again, or its colliders may be elsewhere",
                self.path.display()
            ));
        }
        let stem = into.file_stem().unwrap_or_default().to_string_lossy();
        if into.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("obj")) {
            let counts = counts(&bodies);
            return Ok((self.obj(into, &source, &stem, bodies)?, counts));
        }
        let objects = scene_objects(&shown.to_string(), &stem, &source, &Limits::DEFAULT);
        let objects = objects.map_err(|error| Failure::rejected(error.to_string()))?;
        let file = GltfFile::open(&source.bytes).map_err(fault)?;
        let document: Document = serde_json::from_str(&file.text).map_err(|error| fault(error.to_string()))?;
        let files = document.buffers.iter().chain(&document.images).filter_map(|item| item.uri.as_deref());
        self.check_references(into, files.into_iter().find(|uri| !uri.starts_with("data:")))?;

        let options = self.import_options();
        let owners = self.owners(into, &objects, options.split)?;
        let (bodies, owners) =
            if form.is_in_node { of_first_nodes(into, &document, bodies, owners) } else { (bodies, owners) };
        let bodies = self.named(into, &objects, bodies, &owners)?;
        let counts = counts(&bodies);
        if self.args.target == Some(Target::Godot) {
            warn_of_scales(into, owners.iter().flatten().copied());
        }
        let mesh_of = |owner: &SceneObject| {
            let mesh = document.nodes.get(owner.node)?.mesh?;
            document.meshes.get(mesh as usize)?.name.as_deref()
        };
        let meshes: Vec<&str> = owners.iter().flatten().map(|owner| mesh_of(owner).unwrap_or(&owner.name)).collect();
        let mut mesh_names = names::unreal_beside(&meshes).into_iter().filter(|_| form.is_in_node);
        let colliders: Vec<Collider> = bodies
            .into_iter()
            .zip(&owners)
            .map(|(body, owner)| {
                let pack_in_scene = pack_in_scene(&options, DVec3::from_array(body.origin));
                let pack_in_node = owner.map_or(pack_in_scene, |object| object.node_in_scene.inverse() * pack_in_scene);
                Collider { body, mesh_name: mesh_names.next(), node: owner.map(|object| object.node), pack_in_node }
            })
            .collect();
        if let Some(collider) = colliders.iter().find(|collider| !collider.pack_in_node.is_finite()) {
            let name = &collider.body.name;
            return Err(fault(format!("the node of hull {name} has a scale of 0; correct it, or leave the hull out")));
        }
        let motions = if self.args.is_static || form.is_in_node {
            Vec::new()
        } else {
            self.motions(&owners, &document.parents().map_err(fault)?, &options)?
        };
        Ok((colliders::add(&file, &colliders, &motions, &form).map_err(fault)?, counts))
    }

    fn obj(&self, into: &Path, source: &SourceFile, stem: &str, bodies: Vec<Body>) -> Result<Vec<u8>, Failure> {
        let shown = into.display().to_string();
        let all = ImportOptions { split: Split::Object, ..ImportOptions::DEFAULT };
        let found = import::import(&shown, stem, into, source, &all, &Limits::DEFAULT);
        let found = found.map_err(|error| Failure::rejected(error.to_string()))?;
        let text = std::str::from_utf8(&source.bytes).map_err(|_| {
            Failure::rejected(format!("{shown}: hulls are added to UTF-8 text only; save the file in that encoding"))
        })?;
        let libraries = text.lines().filter_map(|line| line.trim_start().strip_prefix("mtllib "));
        self.check_references(into, libraries.map(str::trim).next())?;
        let object = |(node, set): (usize, &PointSet)| SceneObject {
            name: set.name.clone(),
            node,
            node_in_scene: DAffine3::IDENTITY,
        };
        let objects: Vec<SceneObject> = found.point_sets.iter().enumerate().map(object).collect();
        let options = self.import_options();
        let mut bodies = self.named(into, &objects, bodies, &self.owners(into, &objects, options.split)?)?;
        for body in &mut bodies {
            let place = pack_in_scene(&options, DVec3::from_array(body.origin));
            for position in &mut body.positions {
                *position =
                    place.transform_point3(DVec3::from_array(position.map(f64::from))).to_array().map(|x| x as f32);
            }
        }
        let hulls = obj::objects(&bodies, true, found.vertex_count);
        let meshes = with_groups(text, stem, self.args.name.as_deref());
        Ok(sealed([meshes.as_bytes(), format!("# Hulls, {SEAL}\n").as_bytes(), &hulls].concat()))
    }

    fn import_options(&self) -> ImportOptions {
        let options = BuildOptions::from_recorded(self.pack.options()).map(|options| options.import());
        options.unwrap_or(ImportOptions { split: Split::Object, ..ImportOptions::DEFAULT })
    }

    /// The hulls with the names that the engine expects. Unreal needs a render mesh for each.
    fn named(
        &self,
        into: &Path,
        objects: &[SceneObject],
        mut bodies: Vec<Body>,
        owners: &[Option<&SceneObject>],
    ) -> Result<Vec<Body>, Failure> {
        if self.args.target != Some(Target::Unreal) {
            return Ok(bodies);
        }
        let name = self.args.name.as_deref();
        let meshes: Option<Vec<&str>> =
            owners.iter().map(|owner| name.or(owner.map(|owner| owner.name.as_str()))).collect();
        let Some(meshes) = meshes else {
            return Err(Failure::rejected(format!(
                "{}: its hulls are of the whole file, but Unreal needs the name of a render mesh for each; bake the file \
                 with --split object, or add --name",
                self.path.display()
            )));
        };
        let known: BTreeSet<&str> = meshes.iter().copied().collect();
        let is_part = |name: &str| {
            let mesh = name.strip_prefix("UCX_");
            mesh.is_some_and(|mesh| {
                known.contains(mesh) || mesh.rsplit_once('_').is_some_and(|at| known.contains(at.0))
            })
        };
        if let Some(part) = objects.iter().map(|object| &object.name).find(|name| is_part(name)) {
            return Err(Failure::rejected(format!(
                "{}: already has the collision part {part}; export into the file without it",
                into.display()
            )));
        }
        bodies.iter_mut().zip(names::unreal_beside(&meshes)).for_each(|(body, name)| body.name = name);
        Ok(bodies)
    }

    /// The object that each hull belongs to; `None`: the scene.
    fn owners<'o>(
        &self,
        into: &Path,
        objects: &'o [SceneObject],
        split: Split,
    ) -> Result<Vec<Option<&'o SceneObject>>, Failure> {
        let named: BTreeMap<&str, &SceneObject> = objects.iter().map(|object| (object.name.as_str(), object)).collect();
        let (mut owners, mut unowned) = (Vec::new(), Vec::new());
        for &index in self.indices {
            let Ok(hull) = self.pack.hull(index) else {
                continue;
            };
            let object = names::object(hull.name(), hull.part());
            let owner = named.get(object).copied().or_else(|| match objects {
                [only] if split == Split::None => Some(only),
                _ => None,
            });
            if owner.is_none() {
                unowned.push(object.to_owned());
            }
            owners.push(owner);
        }
        let (Some(first), shown) = (unowned.first(), into.display()) else {
            return Ok(owners);
        };
        if split == Split::None {
            terminal::note(format_args!(
                "{shown}: the hulls are of the whole file, so they are added to the scene, without mass; bake it with \
                 --split object for a body per node"
            ));
            return Ok(owners);
        }
        let some: Vec<&str> = objects.iter().take(NAMES_IN_MESSAGE).map(|object| object.name.as_str()).collect();
        let more = if objects.len() > NAMES_IN_MESSAGE { ", …" } else { "" };
        Err(Failure::rejected(format!(
            "{}: no node of {shown} has the name of hull {first} (it has {}{more}); bake that file with --split object, \
             or select hulls with --hull",
            self.path.display(),
            some.join(", ")
        )))
    }

    fn motions(
        &self,
        owners: &[Option<&SceneObject>],
        parents: &[Option<usize>],
        options: &ImportOptions,
    ) -> Result<Vec<Motion>, Failure> {
        let nodes: BTreeMap<usize, &SceneObject> =
            owners.iter().flatten().map(|object| (object.node, *object)).collect();
        let mut hulls: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (&index, owner) in self.indices.iter().zip(owners) {
            let Some(owner) = owner else {
                continue;
            };
            // The highest node above that has hulls, too. The importer has checked the nodes of the
            // scene. Nodes outside of it may still be their own ancestors, so the walk has an end.
            let above = std::iter::successors(Some(owner.node), |&node| parents.get(node).copied().flatten());
            let above = above.take(parents.len());
            let body = above.filter(|node| nodes.contains_key(node)).last().unwrap_or(owner.node);
            hulls.entry(body).or_default().push(index);
        }
        let mut are_hulls = false;
        let mut motions = Vec::new();
        for (node, indices) in hulls {
            let density = self.args.density.unwrap_or(DENSITY);
            let mass = self.pack.mass_properties_of(indices.iter().copied(), density);
            let mass = mass.map_err(|error| Failure::rejected(format!("{}: {error}", self.path.display())))?;
            let Some(object) = nodes.get(&node) else {
                continue;
            };
            are_hulls |= mass.source == MassSource::Hulls;
            // A density is per unit of the scene: mass grows with the third power of a length, and
            // inertia with the fifth.
            let unit = 1.0 / options.unit_scale;
            // All hulls of a file have one origin.
            let origin = indices.first().and_then(|&index| self.pack.hull(index).ok());
            let origin = origin.map_or(DVec3::ZERO, |hull| hull.origin());
            let center = pack_in_scene(options, origin).transform_point3(mass.center_of_mass);
            let turn = unrotation(options.up_axis);
            let (_, node_rotation, _) = object.node_in_scene.to_scale_rotation_translation();
            let turn = DMat3::from_quat(node_rotation).transpose() * turn;
            let (moments, orientation) = principal_axes(turn * mass.inertia * turn.transpose() * unit.powi(5));
            let center = object.node_in_scene.inverse().transform_point3(center);
            let mass = mass.mass * unit.powi(3);
            // NaN takes the failing branch.
            let is_positive = |x: f64| x > 0.0 && x < f64::INFINITY;
            let is_solid = is_positive(mass) && moments.to_array().into_iter().all(is_positive) && center.is_finite();
            if is_solid {
                motions.push(Motion { node, mass, center, moments, orientation });
            } else {
                terminal::note(format_args!("{}: node {} has no mass", self.path.display(), object.name));
            }
        }
        if are_hulls {
            terminal::note(format_args!(
                "{}: masses come from hulls, where the pack does not record the mass of the mesh (it is open, \
                 triangles are reversed, or only some of its parts are exported)",
                self.path.display()
            ));
        }
        Ok(motions)
    }

    /// Fails if the file refers to another one, `name`, and the output lies in another folder.
    fn check_references(&self, into: &Path, name: Option<&str>) -> Result<(), Failure> {
        let (Some(out), Some(name)) = (&self.args.out, name) else {
            return Ok(());
        };
        let absolute = |path: &Path| folder_of(path).canonicalize().ok();
        if absolute(out).is_some() && absolute(out) == absolute(into) {
            return Ok(());
        }
        Err(Failure::usage(format!(
            "{}: names other files, such as {name}, by their places beside it; write the output to the same folder",
            into.display()
        )))
    }
}

#[derive(Debug, Deserialize)]
struct Document {
    #[serde(default)]
    nodes: Vec<Children>,
    #[serde(default)]
    meshes: Vec<Named>,
    #[serde(default)]
    buffers: Vec<Uri>,
    #[serde(default)]
    images: Vec<Uri>,
}

#[derive(Debug, Deserialize)]
struct Children {
    // Some exporters write all numbers as floats.
    #[serde(default)]
    children: Vec<f64>,
    mesh: Option<f64>,
}

#[derive(Debug, Deserialize)]
struct Named {
    name: Option<String>,
}

#[derive(Debug, Deserialize)]
struct Uri {
    uri: Option<String>,
}

impl Document {
    fn parents(&self) -> Result<Vec<Option<usize>>, String> {
        let mut parents = vec![None; self.nodes.len()];
        for (index, node) in self.nodes.iter().enumerate() {
            for &child in &node.children {
                let Some(parent) = parents.get_mut(child as usize) else {
                    continue;
                };
                if let Some(first) = parent.replace(index)
                    && first != index
                {
                    return Err(format!(
                        "node {child} is below node {first} and below node {index}; expected a tree: export the file again"
                    ));
                }
            }
        }
        Ok(parents)
    }
}

/// The text of an OBJ file in which each object is one group of the same name: Unreal names a mesh
/// by its group, and makes a mesh of each. Without `name`, an object keeps its own, or has the stem
/// of the file.
fn with_groups(text: &str, stem: &str, name: Option<&str>) -> String {
    let (mut grouped, mut is_named) = (String::with_capacity(text.len()), false);
    for line in text.trim_end().lines() {
        let (word, rest) = line.trim().split_once(char::is_whitespace).unwrap_or((line.trim(), ""));
        match word {
            "o" => {
                grouped += &format!("{line}\ng {}\n", name.unwrap_or(rest));
                is_named = true;
                continue;
            }
            "g" => grouped += "# ",
            "f" | "l" | "p" if !is_named => {
                let name = name.unwrap_or(stem).replace(['\n', '\r'], "_");
                grouped += &format!("o {name}\ng {name}\n");
                is_named = true;
            }
            _ => {}
        }
        grouped += line;
        grouped.push('\n');
    }
    grouped
}

/// The hulls of the first node of each mesh: Unreal makes one static mesh of a mesh, wherever its
/// nodes stand, and each hull would count for all of them.
fn of_first_nodes<'o>(
    into: &Path,
    document: &Document,
    bodies: Vec<Body>,
    owners: Vec<Option<&'o SceneObject>>,
) -> (Vec<Body>, Vec<Option<&'o SceneObject>>) {
    // The names of the nodes of each mesh, by their indices.
    let mut nodes: BTreeMap<u64, BTreeMap<usize, &str>> = BTreeMap::new();
    let mesh_of = |owner: &SceneObject| document.nodes.get(owner.node)?.mesh.map(|mesh| mesh as u64);
    for owner in owners.iter().flatten() {
        if let Some(mesh) = mesh_of(owner) {
            nodes.entry(mesh).or_default().insert(owner.node, &owner.name);
        }
    }
    for (mesh, nodes) in nodes.iter().filter(|(_, nodes)| nodes.len() > 1) {
        let name = document.meshes.get(*mesh as usize).and_then(|mesh| mesh.name.clone());
        let (name, first) = (name.unwrap_or_else(|| mesh.to_string()), nodes.values().next().unwrap_or(&""));
        terminal::note(format_args!(
            "{}: {} nodes have mesh {name}, which is one static mesh in Unreal; it gets the hulls of {first}",
            into.display(),
            nodes.len()
        ));
    }
    let is_first = |owner: &Option<&SceneObject>| {
        let first = owner.and_then(|owner| nodes.get(&mesh_of(owner)?)?.keys().next().map(|first| (owner, *first)));
        first.is_none_or(|(owner, first)| owner.node == first)
    };
    bodies.into_iter().zip(owners).filter(|(_, owner)| is_first(owner)).unzip()
}

/// Warns of scaled nodes: Godot supports no scaled bodies.
fn warn_of_scales<'o>(into: &Path, owners: impl Iterator<Item = &'o SceneObject>) {
    let scale = |owner: &SceneObject| owner.node_in_scene.to_scale_rotation_translation().0;
    let is_scaled = |owner: &&SceneObject| !scale(owner).abs_diff_eq(DVec3::ONE, UNSCALED);
    let scaled: BTreeMap<usize, &SceneObject> = owners.filter(is_scaled).map(|owner| (owner.node, owner)).collect();
    let Some(first) = scaled.values().next() else { return };
    let more = if scaled.len() > 1 { format!(" (and {} more)", scaled.len() - 1) } else { String::new() };
    let (file, name, scale) = (into.display(), &first.name, scale(first).to_array().map(rounded).join(" "));
    terminal::warning(format_args!(
        "{file}: node {name} is scaled by {scale}{more}, and Godot supports no scaled bodies; apply the scale in your \
         modeller, or pack with `gltfpack -noq`, and bake again"
    ));
}

/// Transform from the frame of a pack to its source file's: the inverse of the import's.
fn pack_in_scene(options: &ImportOptions, origin: DVec3) -> DAffine3 {
    let linear = unrotation(options.up_axis) * (1.0 / options.unit_scale);
    DAffine3::from_mat3_translation(linear, linear * origin)
}

fn unrotation(up_axis: UpAxis) -> DMat3 {
    match up_axis {
        UpAxis::Keep => DMat3::IDENTITY,
        // (x, −z, y) becomes (x, y, z).
        UpAxis::YToZ => DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y),
        UpAxis::ZToY => DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_placement_of_an_import_is_undone() {
        let [x, y, z] = [3.0, 5.0, 7.0];
        for (up_axis, placed) in [(UpAxis::Keep, [x, y, z]), (UpAxis::YToZ, [x, -z, y]), (UpAxis::ZToY, [x, z, -y])] {
            let options = ImportOptions { unit_scale: 0.01, up_axis, ..ImportOptions::DEFAULT };
            let origin = DVec3::new(0.5, -0.25, 1.0);
            let point = DVec3::from_array(placed) * 0.01 - origin;
            let back = pack_in_scene(&options, origin).transform_point3(point);
            assert!((back - DVec3::new(x, y, z)).length() < 1e-12, "{up_axis:?}: {back}");
        }
    }
}
