//! Hulls as a layer of Universal Scene Description (USD) in its text form: overs on the prims of an
//! asset, which stays as it is.
//!
//! 1. The metadata of the layer: the asset as its sublayer, the unit and the up axis of the stage.
//!    A stage takes unit and axis from its root layer alone, so they are repeated here.
//! 2. An `over` for each prim on the way to a group of hulls, and to a collider that is switched
//!    off (`physics:collisionEnabled`).
//! 3. A group, an `Xform` with one `Mesh` for each hull: a convex collider of the purpose `guide`.
//!    It is beside its mesh, because prims with geometry must not be nested.
//!
//! **Mass.** A simulator adds the masses of a body's colliders. Parts overlap and protrude, so each
//! gets a share of the mesh's mass, its centre of mass and the same share of its inertia. The sum
//! is exactly the mesh's, whichever body the colliders belong to.
//!
//! **Limits on vertices.** Without them, readers would rebuild each hull with 64 vertices or fewer.
//!
//! | reader | attribute | value |
//! |---|---|---|
//! | PhysX | `physxConvexHullCollision:hullVertexLimit`, 64 by default | the hull's, 255 at most |
//! | Newton | `newton:maxHullVertices` | -1: no limit |
//! | MuJoCo | `mjc:maxhullvert` | -1: no limit |
//!
//! # Reference
//! OpenUSD, "Rigid Body Physics in USD" (the schema `usdPhysics`), and "USD File Format"; NVIDIA,
//! Omniverse USD physics schemas, `PhysxConvexHullCollisionAPI`; newton-usd-schemas,
//! `NewtonMeshCollisionAPI`; MuJoCo, `mjcPhysics`, `MjcMeshCollisionAPI`.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use glam::{DMat3, DQuat, DVec3};
use hullmap::{Hull, MassProperties, MassSource, Pack};
use hullmap_import::UpAxis;

use super::body::Body;
use super::glb::bounds;
use super::seal::{SEAL, sealed};
use crate::principal_axes::principal_axes;

/// Maximum number of vertices of a convex hull in PhysX: indices are bytes.
const PHYSX_VERTICES: usize = 255;

const PHYSX_LEAST_VERTICES: usize = 4;

/// Maximum number of prims on the way to another, so that writing does not exhaust the stack.
const MAX_DEPTH: usize = 256;

/// A layer of hulls over an asset.
#[derive(Debug)]
pub struct UsdLayer<'a> {
    /// The asset, as the layer names it: a path relative to the layer, for instance. `None` if the
    /// layer is added to the sublayers of a stage.
    pub asset: Option<String>,
    /// Name of the prim that stands for the stage where it is referenced.
    pub default_prim: Option<String>,
    /// Length of the stage's unit in metres.
    pub meters_per_unit: f64,
    /// The stage's unit of mass in kilograms.
    pub kilograms_per_unit: f64,
    /// The up axis of the stage, `Y` or `Z`.
    pub up_axis: char,
    /// The hulls.
    pub groups: Vec<UsdGroup<'a>>,
    /// Paths of colliders to switch off.
    pub off: Vec<String>,
}

/// Hulls that stand for one mesh.
#[derive(Debug)]
pub struct UsdGroup<'a> {
    /// Path of the prim below which the group is, for instance `/World/chair`; `/` for the root.
    pub parent: String,
    /// Name of the group.
    pub name: String,
    /// Path of the mesh, for the record; empty if it is not known.
    pub mesh: String,
    /// Rows of the matrix from the frame of the hulls to the frame of the parent, for row vectors;
    /// `None` for the same frame.
    pub transform: Option<[[f64; 4]; 4]>,
    /// Whether the group ignores the transforms of its ancestors.
    pub resets_transforms: bool,
    /// The pack of the hulls.
    pub pack: &'a Pack,
    /// Indices of the hulls, all of them solids.
    pub hulls: Vec<usize>,
    /// Rotation of the hulls about x.
    pub rotation: UpAxis,
    /// The mass.
    pub mass: UsdMass,
}

/// The mass of a group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UsdMass {
    /// No mass is written: the simulator computes the mass of each hull.
    None,
    /// The mass at this density, in the stage's unit of mass per cubic unit.
    Density {
        /// The density.
        density: f64,
        /// Scale of the hulls' axes in the world. Mass and inertia belong to the scaled solid; the
        /// centre stays in the frame of the hulls.
        scale: [f64; 3],
    },
    /// This mass, in the stage's unit, distributed as by a density.
    Total {
        /// The mass.
        mass: f64,
        /// As for a density.
        scale: [f64; 3],
    },
}

/// Why a layer cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum UsdError {
    /// A path is not one of a prim.
    #[error(
        "{0}: is not the path of a prim, such as /World/chair: names start with a letter or _, and go on with letters, \
         digits and _"
    )]
    Path(String),
    /// A path has too many prims.
    #[error("{0}…: is a path of more than {MAX_DEPTH} prims; move the mesh higher")]
    Deep(String),
    /// The name of the asset has characters that end a line.
    #[error("{0:?}: control characters cannot be written in the path of an asset; rename the file")]
    Asset(String),
    /// A number is not finite.
    #[error("{0}: a number of its transform, unit or mass is not finite; check the stage")]
    Number(String),
}

/// The layer as text, and the meshes that get the mass of their hulls, without a mass of their own.
///
/// # Errors
/// See [`UsdError`]. Nothing is written for any group if one fails.
pub fn write(layer: &UsdLayer<'_>) -> Result<(String, Vec<String>), UsdError> {
    let mut text = "#usda 1.0\n".to_owned() + &metadata(layer)?;
    let (mut root, mut of_hulls) = (Prim::default(), Vec::new());
    for path in &layer.off {
        root.descend(path)?.is_off = true;
    }
    for group in &layer.groups {
        let (body, source) = group_text(group)?;
        if source == Some(MassSource::Hulls) {
            of_hulls.push(if group.mesh.is_empty() { group.name.clone() } else { group.mesh.clone() });
        }
        root.descend(&group.parent)?.groups.push(body);
    }
    root.write(&mut text, 0);
    let text = String::from_utf8_lossy(&sealed(text.into_bytes())).into_owned();
    Ok((text, of_hulls))
}

fn metadata(layer: &UsdLayer<'_>) -> Result<String, UsdError> {
    let units = [layer.meters_per_unit, layer.kilograms_per_unit];
    // NaN takes the failing branch.
    if !units.iter().all(|unit| *unit > 0.0 && unit.is_finite()) {
        return Err(UsdError::Number("the stage".to_owned()));
    }
    let mut text = "(\n".to_owned();
    if let Some(name) = &layer.default_prim {
        text += &format!("    defaultPrim = {}\n", quoted(name));
    }
    text += &format!("    doc = \"Collision hulls over the prims of the asset, {SEAL}\"\n");
    text += &format!("    kilogramsPerUnit = {}\n    metersPerUnit = {}\n", units[1], units[0]);
    if let Some(asset) = &layer.asset {
        text += &format!("    subLayers = [\n        {}\n    ]\n", asset_path(asset)?);
    }
    Ok(text + &format!("    upAxis = \"{}\"\n)\n", layer.up_axis))
}

/// A prim of the asset, and what the layer states about it and the prims below it.
#[derive(Default)]
struct Prim {
    is_off: bool,
    groups: Vec<String>,
    children: BTreeMap<String, Prim>,
}

impl Prim {
    fn descend(&mut self, path: &str) -> Result<&mut Self, UsdError> {
        let wrong = || UsdError::Path(path.escape_debug().to_string());
        let names = path.strip_prefix('/').ok_or_else(wrong)?;
        if names.split('/').count() > MAX_DEPTH {
            return Err(UsdError::Deep(path.chars().take(40).collect::<String>().escape_debug().to_string()));
        }
        let mut prim = self;
        for name in names.split('/').filter(|_| !names.is_empty()) {
            if !is_identifier(name) {
                return Err(wrong());
            }
            prim = prim.children.entry(name.to_owned()).or_default();
        }
        Ok(prim)
    }

    fn write(&self, text: &mut String, depth: usize) {
        let margin = "    ".repeat(depth);
        if self.is_off {
            *text += &format!("{margin}bool physics:collisionEnabled = 0\n");
        }
        for group in &self.groups {
            for line in group.lines() {
                *text += &format!("{margin}{line}\n");
            }
        }
        for (name, child) in &self.children {
            *text += &format!("\n{margin}over \"{name}\"\n{margin}{{\n");
            child.write(text, depth + 1);
            *text += &format!("{margin}}}\n");
        }
    }
}

fn group_text(group: &UsdGroup<'_>) -> Result<(String, Option<MassSource>), UsdError> {
    if !is_identifier(&group.name) {
        return Err(UsdError::Path(group.name.escape_debug().to_string()));
    }
    let hulls: Vec<Hull> = group.hulls.iter().filter_map(|&index| group.pack.hull(index).ok()).collect();
    let bodies: Vec<Body> = hulls.iter().map(|hull| Body::new(hull, group.rotation)).collect();
    let mut text = format!("\ndef Xform \"{}\"\n{{\n", group.name);
    text += &transform_text(group, bodies.first().map_or([0.0; 3], |body| body.origin))?;
    let mass = mass(group)?;
    let volumes: f64 = hulls.iter().map(Hull::volume).sum();
    for (index, (hull, body)) in hulls.iter().zip(&bodies).enumerate() {
        let share = mass.as_ref().map(|(mass, ..)| (mass, hull.volume() / volumes));
        text += &hull_text(index, hull, body, &group.mesh, share);
    }
    Ok((text + "}\n", mass.map(|(_, source)| source)))
}

/// The transform of a group, if it has one. `origin` is the origin of recentred hulls.
fn transform_text(group: &UsdGroup<'_>, origin: [f64; 3]) -> Result<String, UsdError> {
    let mut rows = group.transform.unwrap_or([[1., 0., 0., 0.], [0., 1., 0., 0.], [0., 0., 1., 0.], [0., 0., 0., 1.]]);
    let moved = [0, 1, 2].map(|column| (0..3).map(|row| origin[row] * rows[row][column]).sum::<f64>());
    for (to, by) in rows[3].iter_mut().zip(moved) {
        *to += by;
    }
    if !rows.iter().flatten().all(|number| number.is_finite()) {
        return Err(UsdError::Number(group.mesh.clone()));
    }
    let mut order = Vec::new();
    let mut text = String::new();
    if group.resets_transforms {
        order.push("\"!resetXformStack!\"");
    }
    if group.transform.is_some() || origin != [0.0; 3] {
        let rows: Vec<String> = rows.iter().map(|row| tuple(row)).collect();
        text += &format!("    matrix4d xformOp:transform = ({})\n", rows.join(", "));
        order.push("\"xformOp:transform\"");
    }
    if !order.is_empty() {
        text += &format!("    uniform token[] xformOpOrder = [{}]\n", order.join(", "));
    }
    Ok(text)
}

/// One hull as a convex collider. `share` is the mass of the group, and the hull's share of it.
fn hull_text(index: usize, hull: &Hull, body: &Body, mesh: &str, share: Option<(&Principal, f64)>) -> String {
    let mut schemas =
        vec!["PhysicsCollisionAPI", "PhysicsMeshCollisionAPI", "PhysxConvexHullCollisionAPI", "NewtonMeshCollisionAPI"];
    schemas.push("MjcMeshCollisionAPI");
    if share.is_some() {
        schemas.push("PhysicsMassAPI");
    }
    let schemas: Vec<String> = schemas.iter().map(|schema| format!("\"{schema}\"")).collect();
    let mut text = format!("\n    def Mesh \"hull_{index:02}\" (\n        customData = {{\n");
    text += &record_text(hull, mesh);
    text += &format!("        }}\n        prepend apiSchemas = [{}]\n    )\n    {{\n", schemas.join(", "));
    let [low, high] = bounds(&body.positions);
    let triangles: Vec<[u32; 3]> = body.triangles().collect();
    text += &format!("        float3[] extent = [{}, {}]\n", tuple(&low), tuple(&high));
    text += &format!("        int[] faceVertexCounts = [{}]\n", list(triangles.iter().map(|_| 3)));
    text += &format!("        int[] faceVertexIndices = [{}]\n", list(triangles.iter().flatten()));
    // A stronger opinion than an inherited one.
    text += "        bool physics:collisionEnabled = 1\n        uniform token physics:approximation = \"convexHull\"\n";
    let limit = body.positions.len().clamp(PHYSX_LEAST_VERTICES, PHYSX_VERTICES);
    text += &format!("        int physxConvexHullCollision:hullVertexLimit = {limit}\n");
    text += "        uniform int newton:maxHullVertices = -1\n        uniform int mjc:maxhullvert = -1\n";
    if let Some((mass, share)) = share {
        text += &format!("        point3f physics:centerOfMass = {}\n", tuple(&mass.center.map(|x| x as f32)));
        let inertia = mass.moments.to_array().map(|moment| (moment * share) as f32);
        text += &format!("        float3 physics:diagonalInertia = {}\n", tuple(&inertia));
        text += &format!("        float physics:mass = {}\n", (mass.mass * share) as f32);
        let [x, y, z, w] = mass.axes.to_array().map(|x| x as f32);
        text += &format!("        quatf physics:principalAxes = {}\n", tuple(&[w, x, y, z]));
    }
    text += &format!("        point3f[] points = [{}]\n", list(body.positions.iter().map(|point| tuple(point))));
    text + "        uniform token purpose = \"guide\"\n        uniform token subdivisionScheme = \"none\"\n    }\n"
}

/// The bounds that the pack records, as custom data. Lengths are in the frame of the hulls.
fn record_text(hull: &Hull, mesh: &str) -> String {
    let mut text = "            dictionary hullmap = {\n".to_owned();
    let mut number = |key: &str, value: f64| {
        if value.is_finite() {
            text += &format!("                double {key} = {value}\n");
        }
    };
    number("containmentError", hull.containment_error());
    number("outerError", hull.outer_error());
    for (key, value) in [("protrusion", hull.protrusion()), ("uncovered", hull.uncovered())] {
        if let Some(value) = value {
            number(key, value);
        }
    }
    if !mesh.is_empty() {
        text += &format!("                string mesh = {}\n", quoted(mesh));
    }
    if let Some(solid) = hull.solid() {
        text += &format!("                string solid = {}\n", quoted(solid.as_str()));
    }
    text + "            }\n"
}

#[derive(Debug)]
struct Principal {
    mass: f64,
    center: [f64; 3],
    moments: DVec3,
    axes: DQuat,
}

fn mass(group: &UsdGroup<'_>) -> Result<Option<(Principal, MassSource)>, UsdError> {
    let (density, total, scale) = match group.mass {
        UsdMass::None => return Ok(None),
        UsdMass::Density { density, scale } => (density, None, scale),
        UsdMass::Total { mass, scale } => (1.0, Some(mass), scale),
    };
    if ![density, total.unwrap_or(1.0)].iter().chain(&scale).all(|number| number.is_finite()) {
        return Err(UsdError::Number(group.mesh.clone()));
    }
    let Ok(found) = group.pack.mass_properties_of(group.hulls.iter().copied(), density) else { return Ok(None) };
    let own = turned(&found, group.rotation);
    let scaled = own.scaled(DVec3::from_array(scale));
    let factor = total.map_or(1.0, |total| total / scaled.mass);
    let (moments, axes) = principal_axes(scaled.inertia * factor);
    let mass = scaled.mass * factor;
    // Moments of a sliver may be negative by rounding; such a body has no usable inertia.
    if !(mass > 0.0 && mass.is_finite() && moments.to_array().iter().all(|moment| *moment > 0.0 && moment.is_finite()))
    {
        return Ok(None);
    }
    Ok(Some((Principal { mass, center: own.center_of_mass.to_array(), moments, axes }, found.source)))
}

fn turned(found: &MassProperties, rotation: UpAxis) -> MassProperties {
    let by = match rotation {
        UpAxis::Keep => return *found,
        UpAxis::YToZ => DMat3::from_cols(DVec3::X, DVec3::Z, -DVec3::Y),
        UpAxis::ZToY => DMat3::from_cols(DVec3::X, -DVec3::Z, DVec3::Y),
    };
    MassProperties { center_of_mass: by * found.center_of_mass, inertia: by * found.inertia * by.transpose(), ..*found }
}

/// Numbers in parentheses. Each is the shortest that reads back with all bits.
fn tuple<T: std::fmt::Display>(numbers: &[T]) -> String {
    format!("({})", list(numbers.iter()))
}

fn list<T: std::fmt::Display>(items: impl Iterator<Item = T>) -> String {
    let mut text = String::new();
    for item in items {
        let separator = if text.is_empty() { "" } else { ", " };
        let _ = write!(text, "{separator}{item}");
    }
    text
}

/// Whether a prim may have this name. Letters are defined by Unicode, as in OpenUSD since 24.03.
fn is_identifier(name: &str) -> bool {
    let mut letters = name.chars();
    letters.next().is_some_and(|first| first == '_' || first.is_alphabetic())
        && letters.all(|letter| letter == '_' || letter.is_alphanumeric())
}

/// A name for a prim by the rules of `Tf.MakeValidIdentifier`: each byte that is no letter, digit
/// or `_` of ASCII becomes `_`, and so does a digit at the start.
pub fn identifier(name: &str) -> String {
    let kept = |(at, byte): (usize, u8)| {
        let is_kept = byte == b'_' || byte.is_ascii_alphabetic() || at > 0 && byte.is_ascii_digit();
        if is_kept { char::from(byte) } else { '_' }
    };
    let name: String = name.bytes().enumerate().map(kept).collect();
    if name.is_empty() { "_".to_owned() } else { name }
}

fn quoted(text: &str) -> String {
    let mut quoted = "\"".to_owned();
    for letter in text.chars() {
        match letter {
            '"' | '\\' => quoted.extend(['\\', letter]),
            '\n' => quoted += "\\n",
            // A control character would end the line for some readers.
            _ if letter.is_control() || matches!(letter, '\u{2028}' | '\u{2029}') => quoted.push('_'),
            _ => quoted.push(letter),
        }
    }
    quoted + "\""
}

/// The path of an asset between `@`, or between `@@@` if it has an `@` itself.
fn asset_path(path: &str) -> Result<String, UsdError> {
    if path.is_empty() || path.contains(char::is_control) {
        return Err(UsdError::Asset(path.to_owned()));
    }
    Ok(if path.contains('@') { format!("@@@{}@@@", path.replace("@@@", "\\@@@")) } else { format!("@{path}@") })
}

#[cfg(test)]
mod tests {
    use hullmap_bake::{IndexKind, PointSet, bake_hull, write_pack};

    use super::*;

    fn cuboid(edges: [f32; 3]) -> Pack {
        let corner = |i: usize| [0, 1, 2].map(|axis| edges[axis] * f32::from((i >> axis & 1) as u8));
        let points = PointSet::of_positions((0..8).map(corner).collect());
        let baked = bake_hull(&points, IndexKind::None).unwrap();
        Pack::from_bytes(&write_pack(&[baked], &Default::default()).unwrap()).unwrap()
    }

    fn group<'a>(pack: &'a Pack, mass: UsdMass) -> UsdGroup<'a> {
        UsdGroup {
            parent: "/World".to_owned(),
            name: "box_hulls".to_owned(),
            mesh: "/World/box".to_owned(),
            transform: None,
            resets_transforms: false,
            pack,
            hulls: vec![0],
            rotation: UpAxis::Keep,
            mass,
        }
    }

    fn layer(groups: Vec<UsdGroup<'_>>) -> UsdLayer<'_> {
        UsdLayer {
            asset: Some("./a.usd".to_owned()),
            default_prim: Some("World".to_owned()),
            meters_per_unit: 0.01,
            kilograms_per_unit: 1.0,
            up_axis: 'Y',
            groups,
            off: vec!["/World/box".to_owned()],
        }
    }

    #[test]
    fn identifiers_follow_the_rules_of_tf() {
        let expected = [
            ("chair", "chair"),
            ("", "_"),
            ("2nd floor", "_nd_floor"),
            ("a\"\n@b", "a___b"),
            ("é", "__"),
            ("_1", "_1"),
        ];
        for (name, wanted) in expected {
            assert_eq!(identifier(name), wanted, "{name:?}");
            assert!(is_identifier(wanted));
        }
    }

    #[test]
    fn strings_and_assets_end_where_they_should() {
        assert_eq!(quoted("a\"b\\c\nd\u{7}e\u{2028}"), "\"a\\\"b\\\\c\\nd_e_\"");
        assert_eq!(asset_path("./a.usd").unwrap(), "@./a.usd@");
        assert_eq!(asset_path("a@b@@@c").unwrap(), "@@@a@b\\@@@c@@@");
        assert!(matches!(asset_path("a\n@b"), Err(UsdError::Asset(_))));
    }

    #[test]
    fn paths_that_are_none_are_rejected() {
        let pack = cuboid([1.0; 3]);
        for path in ["World", "", "/a b", "/a//b", "/a{v=x}b", "/a.b", "/1", "/a\" {", "/a/"] {
            let mut wrong = layer(vec![UsdGroup { parent: path.to_owned(), ..group(&pack, UsdMass::None) }]);
            assert!(matches!(write(&wrong), Err(UsdError::Path(_))), "{path}");
            wrong.groups.clear();
            wrong.off = vec![path.to_owned()];
            assert!(matches!(write(&wrong), Err(UsdError::Path(_))), "{path}");
        }
        let deep = layer(vec![UsdGroup { parent: "/a".repeat(100_000), ..group(&pack, UsdMass::None) }]);
        assert!(matches!(write(&deep), Err(UsdError::Deep(_))));
        let nan = layer(vec![UsdGroup { transform: Some([[f64::NAN; 4]; 4]), ..group(&pack, UsdMass::None) }]);
        assert!(matches!(write(&nan), Err(UsdError::Number(_))));
        assert!(matches!(write(&UsdLayer { meters_per_unit: 0.0, ..layer(Vec::new()) }), Err(UsdError::Number(_))));
    }

    #[test]
    fn a_box_has_the_mass_of_the_formula() {
        let pack = cuboid([1.0, 2.0, 4.0]);
        let scale = [3.0, 1.0, 0.5];
        let (mass, source) = mass(&group(&pack, UsdMass::Density { density: 2.0, scale })).unwrap().unwrap();
        assert_eq!(source, MassSource::Hulls);
        assert!((mass.mass - 24.0).abs() < 1e-12, "{mass:?}");
        assert!(DVec3::from_array(mass.center).abs_diff_eq(DVec3::new(0.5, 1.0, 2.0), 1e-12), "{mass:?}");
        let mut moments = mass.moments.to_array();
        moments.sort_by(f64::total_cmp);
        for (found, wanted) in moments.iter().zip([16.0, 26.0, 26.0]) {
            assert!((found - wanted).abs() < 1e-9, "{mass:?}");
        }
        let total = super::mass(&group(&pack, UsdMass::Total { mass: 6.0, scale })).unwrap().unwrap().0;
        assert!((total.mass - 6.0).abs() < 1e-12 && (total.moments.element_sum() - 17.0).abs() < 1e-9);
        let (text, of_hulls) = write(&layer(vec![group(&pack, UsdMass::Density { density: 2.0, scale })])).unwrap();
        assert_eq!(of_hulls, ["/World/box"]);
        for line in [
            "    metersPerUnit = 0.01\n    subLayers = [\n        @./a.usd@\n    ]\n    upAxis = \"Y\"\n",
            "    over \"box\"\n    {\n        bool physics:collisionEnabled = 0\n    }\n",
            "            float physics:mass = 24\n",
            "            uniform token purpose = \"guide\"\n",
            "            int physxConvexHullCollision:hullVertexLimit = 8\n",
        ] {
            assert!(text.contains(line), "{line}\n{text}");
        }
    }
}
