//! Nodes, transforms and instances of a COLLADA scene.

use std::collections::{BTreeSet, HashMap};

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use roxmltree::{Document, Node};

use super::geometry::{Target, positions_of};
use super::xml::{child, fault_at, local, number};
use crate::fault::{LineFault, excerpt};
use crate::limits::{GLTF_LIST, Limits};
use crate::mesh::{Polygons, Positions, SourceMesh};

/// Maximum depth of nodes. Instances may form a cycle, which never ends.
const MAX_DEPTH: usize = 256;

/// Bytes of a geometry that count as a vertex, if it is read again.
const BYTES_A_VERTEX: usize = 8;

/// Bytes of the name of an object that count as a node.
const BYTES_A_VISIT: usize = 64;

/// The mesh of the scene, in metres.
pub fn read(document: &Document, limits: &Limits) -> Result<SourceMesh, LineFault> {
    let mut ids: HashMap<&str, Node> = HashMap::new();
    for node in document.descendants() {
        if let Some(id) = node.attribute("id") {
            ids.entry(id).or_insert(node);
        }
    }
    let root = document.root_element();
    let asset = child(root, "asset");
    let unit = asset.and_then(|asset| child(asset, "unit")).and_then(|unit| unit.attribute("meter"));
    let metres = unit.map_or(Ok(1.0), |text| {
        let metres =
            text.trim().replace(',', ".").parse().ok().filter(|metres: &f64| *metres > 0.0 && metres.is_finite());
        metres.ok_or_else(|| {
            LineFault::of_file(format!("the unit of {} metres is no length: correct `unit meter`", excerpt(text)))
        })
    })?;
    let mut reader = Reader {
        mesh: SourceMesh::new(Positions::Double(Vec::new()), Polygons::default()),
        ids,
        used: BTreeSet::new(),
        limits,
        repeated: 0,
        object_count: 0,
        visits: 0,
        has_holes: false,
    };
    let scene = scene(root, &reader.ids)?;
    match scene {
        Some(scene) => reader.walk(scene, DAffine3::from_scale(DVec3::splat(metres)))?,
        // A library of geometries alone.
        None => {
            let geometries = document.descendants().filter(|node| node.tag_name().name() == "geometry");
            for geometry in geometries.collect::<Vec<Node>>() {
                reader.add(geometry, geometry, DAffine3::from_scale(DVec3::splat(metres)))?;
            }
        }
    }
    let up = asset.and_then(|asset| child(asset, "up_axis")).and_then(|up| up.text()).map(str::trim);
    reader.finish(metres, up)
}

fn scene<'a, 'input>(
    root: Node<'a, 'input>,
    ids: &HashMap<&str, Node<'a, 'input>>,
) -> Result<Option<Node<'a, 'input>>, LineFault> {
    let instance = child(root, "scene").and_then(|scene| child(scene, "instance_visual_scene"));
    let Some(instance) = instance else {
        return Ok(child(root, "library_visual_scenes").and_then(|library| child(library, "visual_scene")));
    };
    let id = local(instance, "url")?;
    let found = ids.get(id).copied().filter(|scene| scene.tag_name().name() == "visual_scene");
    found
        .map(Some)
        .ok_or_else(|| fault_at(instance, format!("there is no visual scene `{}`: export the file again", excerpt(id))))
}

struct Reader<'a, 'input, 'l> {
    mesh: SourceMesh,
    ids: HashMap<&'a str, Node<'a, 'input>>,
    /// The geometries that were added, by their places.
    used: BTreeSet<usize>,
    limits: &'l Limits,
    repeated: usize,
    object_count: usize,
    /// Nodes that were walked, and names of objects in bytes.
    visits: usize,
    has_holes: bool,
}

impl<'a, 'input> Reader<'a, 'input, '_> {
    fn walk(&mut self, scene: Node<'a, 'input>, placed: DAffine3) -> Result<(), LineFault> {
        let mut waiting: Vec<(Node, DAffine3, usize)> = vec![(scene, placed, 0)];
        while let Some((node, outer, depth)) = waiting.pop() {
            self.visits += 1;
            if depth > MAX_DEPTH || self.visits > GLTF_LIST {
                let text = format!(
                    "the scene has more than {GLTF_LIST} nodes, or nodes deeper than {MAX_DEPTH}; instances may form a cycle: remove it"
                );
                return Err(fault_at(node, text));
            }
            let placed = outer * transform(node)?;
            let mut inner = Vec::new();
            for own in node.children().filter(Node::is_element) {
                match own.tag_name().name() {
                    "node" => inner.push((own, placed, depth + 1)),
                    "instance_node" => inner.push((self.named(own, "node")?, placed, depth + 1)),
                    "instance_geometry" => self.add(self.named(own, "geometry")?, node, placed)?,
                    "instance_controller" => {
                        let controller = self.named(own, "controller")?;
                        if let Some(skin) = child(controller, "skin").or_else(|| child(controller, "morph"))
                            && let Some(&geometry) = self.ids.get(local(skin, "source")?)
                        {
                            let bind = child(skin, "bind_shape_matrix").map_or(Ok(DAffine3::IDENTITY), matrix)?;
                            self.add(geometry, node, placed * bind)?;
                        }
                    }
                    _ => {}
                }
            }
            waiting.extend(inner.into_iter().rev());
        }
        Ok(())
    }

    fn named(&self, instance: Node<'a, 'input>, kind: &str) -> Result<Node<'a, 'input>, LineFault> {
        let id = local(instance, "url")?;
        let found = self.ids.get(id).copied().filter(|node| node.tag_name().name() == kind);
        found.ok_or_else(|| fault_at(instance, format!("there is no {kind} `{}`: export the file again", excerpt(id))))
    }

    fn add(&mut self, geometry: Node<'a, 'input>, node: Node<'a, 'input>, placed: DAffine3) -> Result<(), LineFault> {
        let Some((mesh, source)) = positions_of(geometry, &self.ids)? else { return Ok(()) };
        self.begin_object(node);
        let Positions::Double(positions) = &mut self.mesh.positions else { return Ok(()) };
        let before = positions.len() + self.mesh.faces.corners.len() + self.mesh.loose.len();
        let (faces, loose) = (&mut self.mesh.faces, &mut self.mesh.loose);
        let mut target = Target { positions, faces, loose, placed, has_holes: false };
        target.append(mesh, source)?;
        self.has_holes |= target.has_holes;
        if !self.used.insert(geometry.range().start) {
            let added = self.mesh.positions.len() + self.mesh.faces.corners.len() + self.mesh.loose.len() - before;
            // Reading takes time even where it adds little.
            self.repeated = self.repeated.saturating_add(added.max(geometry.range().len() / BYTES_A_VERTEX));
            if self.repeated > self.limits.repeated_vertices {
                let limit = self.limits.repeated_vertices;
                let text = format!(
                    "instances add more than {limit} vertices and corners: apply them in the editor, or raise --set max_instanced"
                );
                return Err(fault_at(node, text));
            }
        }
        Ok(())
    }

    fn begin_object(&mut self, node: Node) {
        let name = node.attribute("name").or_else(|| node.attribute("id")).unwrap_or_default();
        self.visits += name.len() / BYTES_A_VISIT;
        self.object_count += 1;
        if self.object_count == 1 {
            if let Some(first) = self.mesh.objects.first_mut() {
                first.name = name.to_owned();
            }
        } else if self.mesh.objects.len() >= self.limits.objects {
            self.mesh.has_too_many_objects = true;
        } else {
            self.mesh.begin_object(name.to_owned(), self.limits.objects);
        }
    }

    fn finish(mut self, metres: f64, up: Option<&str>) -> Result<SourceMesh, LineFault> {
        if self.mesh.positions.len() == 0 {
            let text =
                "the scene shows no geometry, but a hull requires at least one point: check that the export finished";
            return Err(LineFault::of_file(text));
        }
        if metres != 1.0 {
            self.mesh.notes.push(format!("the file's unit is {metres} m; its coordinates were converted to metres"));
        }
        if let Some(up) = up.filter(|up| *up != "Z_UP") {
            self.mesh.notes.push(format!("the file states the up axis {}, which is not applied", excerpt(up)));
        }
        if self.has_holes {
            self.mesh
                .warnings
                .push("polygons have holes, which are left out: triangulate the mesh in its editor".to_owned());
        }
        Ok(self.mesh)
    }
}

/// The transform of a node: the product of its elements, in their order.
fn transform(node: Node) -> Result<DAffine3, LineFault> {
    let mut product = DAffine3::IDENTITY;
    for own in node.children().filter(Node::is_element) {
        let kind = own.tag_name().name();
        let step = match kind {
            "matrix" => matrix(own)?,
            "translate" => DAffine3::from_translation(DVec3::from_array(exactly(own)?)),
            "scale" => DAffine3::from_scale(DVec3::from_array(exactly(own)?)),
            "rotate" => {
                let [x, y, z, degrees] = exactly(own)?;
                let axis = DVec3::new(x, y, z).try_normalize();
                let angle = f64::to_radians(degrees);
                axis.map_or(DAffine3::IDENTITY, |axis| DAffine3::from_quat(DQuat::from_axis_angle(axis, angle)))
            }
            "lookat" => look_at(own)?,
            "skew" => {
                return Err(fault_at(own, "a transform is `skew`, which is not supported: apply it in the editor"));
            }
            _ => continue,
        };
        product *= step;
    }
    Ok(product)
}

fn exactly<const N: usize>(node: Node) -> Result<[f64; N], LineFault> {
    let text = node.text().unwrap_or_default();
    let words = text.split_ascii_whitespace();
    // One more than expected is enough to reject them.
    let numbers: Vec<f64> = words.take(N + 1).map(|word| number(node, word)).collect::<Result<_, _>>()?;
    let count = text.split_ascii_whitespace().count();
    <[f64; N]>::try_from(numbers).map_err(|_| {
        fault_at(
            node,
            format!("`{}` has {count} numbers; expected {N}: export the file again", excerpt(node.tag_name().name())),
        )
    })
}

/// A matrix, written by rows.
fn matrix(node: Node) -> Result<DAffine3, LineFault> {
    let rows: [f64; 16] = exactly(node)?;
    let matrix = DMat4::from_cols_array(&rows).transpose();
    if matrix.row(3).to_array() != [0.0, 0.0, 0.0, 1.0] {
        return Err(fault_at(
            node,
            "the last row of the matrix is not 0 0 0 1, but only affine transforms are supported: correct it",
        ));
    }
    Ok(DAffine3::from_mat4(matrix))
}

/// The frame of a viewer: its origin, a point that it looks at along −z, and its up direction.
fn look_at(node: Node) -> Result<DAffine3, LineFault> {
    let [ex, ey, ez, cx, cy, cz, ux, uy, uz] = exactly(node)?;
    let (eye, centre, up) = (DVec3::new(ex, ey, ez), DVec3::new(cx, cy, cz), DVec3::new(ux, uy, uz));
    let back = (eye - centre).try_normalize();
    let frame = back.and_then(|z| Some((up.cross(z).try_normalize()?, z)));
    let (x, z) = frame.ok_or_else(|| fault_at(node, "`lookat` has no direction: correct it"))?;
    Ok(DAffine3 { matrix3: DMat3::from_cols(x, z.cross(x), z), translation: eye })
}
