//! The report page of a robot, from the description, the packs and the mesh files.

use std::collections::BTreeMap;
use std::path::PathBuf;

use glam::DVec3;
use hullmap_report::input::Remarks;
use hullmap_report::robot as report;
use hullmap_report::{DisplayMesh, robot_page};
use hullmap_robot::{Chain, Description, Frame, Geometry, Joint, MeshUse, Motion, Primitive, Shape, Submesh};

use super::choice::{Choice, Choices, ShapeChoice};
use super::hulls::Hulls;
use super::meshes::Meshes;
use super::pairs::Pairs;
use super::rows::Row;
use hullmap_verify::geometry::polygons;

#[derive(PartialEq, Eq, PartialOrd, Ord)]
enum Key {
    File(FileKey),
    HullOf(FileKey),
    Hull(usize, usize),
    Primitive(String),
}

type FileKey = (PathBuf, Option<Submesh>);

fn key(mesh: &MeshUse) -> Option<FileKey> {
    Some((mesh.file.as_ref().ok()?.clone(), mesh.submesh.clone()))
}

pub struct Gatherer<'a> {
    pub description: &'a Description,
    pub choices: &'a Choices,
    pub hulls: &'a [Hulls],
    pub meshes: &'a mut Meshes,
}

pub fn page(gatherer: Gatherer, pairs: &Pairs, row: &Row) -> String {
    let description = gatherer.description;
    let mut canvas = Canvas { gatherer, known: BTreeMap::new(), meshes: Vec::new() };
    let neutral = pairs.neutral();
    let links = (0..description.links.len()).map(|link| canvas.link(link, neutral[link], pairs, row)).collect();
    let Canvas { gatherer, meshes, .. } = canvas;
    // Warnings of bakes are left out: fresh packs have none, and equal inputs give equal pages.
    let mut notes = description.notes.clone();
    notes.extend(description.chain.notes.iter().map(|note| format!("{}: {note}", row.file)));
    notes.extend(gatherer.meshes.faults.iter().map(|fault| format!("{fault}; it is not drawn")));
    robot_page(&report::Robot {
        file: row.file.clone(),
        output: row.output.clone().unwrap_or_default(),
        format: description.format.name().to_owned(),
        meshes,
        links,
        joints: description.chain.joints.iter().map(joint).collect(),
        touching: pairs.touching.clone(),
        excluded: pairs.excluded.clone(),
        exclusion: pairs.in_words(),
        remarks: Remarks { faults: Vec::new(), warnings: row.warnings.clone(), notes },
    })
}

fn placement(frame: Frame) -> report::Placement {
    report::Placement { rotation: frame.rotation.to_array(), translation: frame.translation.to_array() }
}

fn joint(joint: &Joint) -> report::Joint {
    report::Joint {
        name: joint.name.clone(),
        link: joint.link,
        motion: match joint.motion {
            Motion::Hinge => report::Motion::Hinge,
            Motion::Slide => report::Motion::Slide,
            Motion::Ball | Motion::Free => report::Motion::Other,
        },
        axis: joint.axis.to_array(),
        anchor: joint.anchor.to_array(),
        limits: joint.limits,
        reference: joint.reference,
        neutral: joint.neutral,
        coefficients: joint.coupling.map(|coupling| coupling.coefficients.to_vec()).unwrap_or_default(),
        leader: joint.coupling.and_then(|coupling| coupling.leader),
    }
}

struct Canvas<'a> {
    gatherer: Gatherer<'a>,
    known: BTreeMap<Key, usize>,
    meshes: Vec<DisplayMesh>,
}

impl Canvas<'_> {
    fn link(&mut self, index: usize, neutral: Frame, pairs: &Pairs, row: &Row) -> report::Link {
        let description = self.gatherer.description;
        let choices: Vec<&ShapeChoice> = self.gatherer.choices.shapes.iter().filter(|own| own.link == index).collect();
        let link = &description.links[index];
        let mut shapes = Vec::new();
        for shape in link.visuals.iter().chain(&link.collisions).filter(|shape| shape.is_drawn) {
            shapes.extend(self.as_is(shape, report::Layer::Visual));
        }
        for shape in &link.collisions {
            shapes.extend(self.as_hull(shape, report::Layer::Before));
        }
        for own in &choices {
            shapes.extend(self.after(own));
        }
        let chain: &Chain = &description.chain;
        let rows = row.collisions.iter().zip(&self.gatherer.choices.shapes).filter(|(_, own)| own.link == index);
        let rows: Vec<_> = rows.map(|(row, _)| row).collect();
        let mut becomes: Vec<&str> = rows.iter().map(|row| row.action).collect();
        becomes.dedup();
        let bounds = |bounds: Vec<Option<f64>>| bounds.into_iter().flatten().reduce(f64::max);
        let after = choices.iter().zip(&rows).map(|(own, row)| row.protrusion_mm.or_else(|| self.protrusion_mm(own)));
        let after = bounds(after.collect());
        let before = bounds(link.collisions.iter().map(|shape| self.hull_protrusion_mm(shape)).collect());
        let vertices: Vec<usize> = rows.iter().filter_map(|row| row.vertices).collect();
        report::Link {
            name: link.name.clone(),
            parent: chain.links[index].parent,
            rest: placement(chain.links[index].rest),
            neutral: placement(neutral),
            shapes,
            becomes: becomes.join(", "),
            pieces: [pairs.before.count(index), pairs.after.count(index)],
            vertices: (!vertices.is_empty()).then(|| vertices.iter().sum()),
            protrusion_mm: [before, after],
            uncovered_mm: bounds(rows.iter().map(|row| row.uncovered_mm).collect()),
        }
    }

    fn protrusion_mm(&mut self, own: &ShapeChoice) -> Option<f64> {
        let shape = self.gatherer.choices.shape(own, self.gatherer.description);
        match own.choice {
            Choice::Removed => None,
            Choice::Hulls(own) if self.gatherer.hulls[own].is_parts => None,
            _ => self.hull_protrusion_mm(shape),
        }
    }

    fn hull_protrusion_mm(&mut self, shape: &Shape) -> Option<f64> {
        let Geometry::Mesh(mesh) = &shape.geometry else { return None };
        let protrusion = self.gatherer.meshes.get(mesh)?.protrusion()?;
        Some(protrusion * mesh.stretch() * 1000.0)
    }

    fn after(&mut self, own: &ShapeChoice) -> Vec<report::Shape> {
        let shape = self.gatherer.choices.shape(own, self.gatherer.description);
        match (&own.choice, &shape.geometry) {
            (Choice::Removed, _) => Vec::new(),
            (Choice::Hulls(index), Geometry::Mesh(mesh)) if self.gatherer.hulls[*index].fault.is_none() => {
                let pack = self.gatherer.hulls[*index].pack.clone();
                let place = |(part, hull): (usize, hullmap::Hull)| {
                    let drawn = || DisplayMesh::of_hull(&hull, &polygons(&hull));
                    self.placed(Key::Hull(*index, part), drawn, mesh, shape, report::Layer::After)
                };
                pack.hulls().enumerate().filter_map(place).collect()
            }
            _ => self.as_hull(shape, report::Layer::After).into_iter().collect(),
        }
    }

    fn as_is(&mut self, shape: &Shape, layer: report::Layer) -> Option<report::Shape> {
        let Geometry::Mesh(mesh) = &shape.geometry else { return self.as_primitive(shape, layer) };
        let own = self.gatherer.meshes.get(mesh)?;
        self.placed(Key::File(key(mesh)?), || own.display.clone(), mesh, shape, layer)
    }

    fn as_hull(&mut self, shape: &Shape, layer: report::Layer) -> Option<report::Shape> {
        let Geometry::Mesh(mesh) = &shape.geometry else { return self.as_primitive(shape, layer) };
        let own = self.gatherer.meshes.get(mesh)?;
        let pack = own.hull().ok()?;
        let hull = pack.hull(0).ok()?;
        self.placed(Key::HullOf(key(mesh)?), || DisplayMesh::of_hull(&hull, &polygons(&hull)), mesh, shape, layer)
    }

    fn as_primitive(&mut self, shape: &Shape, layer: report::Layer) -> Option<report::Shape> {
        let Geometry::Primitive(primitive) = &shape.geometry else { return None };
        let primitive = primitive.shape?;
        let mesh = self.mesh(Key::Primitive(format!("{primitive:?}")), || drawn_primitive(primitive))?;
        let frame = shape.pose?;
        let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| frame.rotation * axis);
        Some(report::Shape { layer, mesh, in_link: columns(axes, frame.translation) })
    }

    fn placed(
        &mut self,
        key: Key,
        make: impl FnOnce() -> DisplayMesh,
        mesh: &MeshUse,
        shape: &Shape,
        layer: report::Layer,
    ) -> Option<report::Shape> {
        let frame = shape.pose?;
        let origin = mesh.placed(DVec3::ZERO);
        let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| frame.rotation * (mesh.placed(axis) - origin));
        let mesh = self.mesh(key, make)?;
        Some(report::Shape { layer, mesh, in_link: columns(axes, frame.apply(origin)) })
    }

    fn mesh(&mut self, key: Key, make: impl FnOnce() -> DisplayMesh) -> Option<usize> {
        let next = self.meshes.len();
        let index = *self.known.entry(key).or_insert(next);
        if index == next {
            self.meshes.push(make());
        }
        Some(index)
    }
}

fn columns(axes: [DVec3; 3], origin: DVec3) -> [[f64; 3]; 4] {
    let [x, y, z] = axes.map(|axis| axis.to_array());
    [x, y, z, origin.to_array()]
}

fn drawn_primitive(primitive: Primitive) -> DisplayMesh {
    match primitive {
        Primitive::Box(half) => DisplayMesh::cuboid(half),
        Primitive::Sphere(radius) => DisplayMesh::ellipsoid([radius; 3]),
        Primitive::Cylinder([radius, half_length]) => DisplayMesh::cylinder(radius, half_length),
        Primitive::Capsule([radius, half_length]) => DisplayMesh::capsule(radius, half_length),
        Primitive::Ellipsoid(radii) => DisplayMesh::ellipsoid(radii),
        Primitive::Cone([radius, half_length]) => DisplayMesh::cone(radius, half_length),
    }
}
