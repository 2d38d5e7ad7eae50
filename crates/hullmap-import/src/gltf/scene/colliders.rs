//! glTF 2.0: colliders of nodes, read as objects of the source mesh.
//!
//! A collider stands for the mesh of its node, or else of the nearest node above that has one. A
//! mesh that only a collider refers to is not drawn, so it belongs to no other object.

use std::collections::HashSet;

use glam::DAffine3;

use super::{SceneReader, local};
use crate::fault::{Fault, counted};
use crate::gltf::document::Node;
use crate::gltf::physics::Geometry;
use crate::mesh::SourceCollider;

/// Bytes of the file that a node should have taken: at least `{}`.
const NODE_BYTES: usize = 2;

impl SceneReader<'_> {
    /// Adds the node's collider, if there is one to read. `label` names it in messages.
    pub(super) fn add_collider(
        &mut self,
        node: &Node,
        label: &str,
        transform: DAffine3,
        stands_for: Option<usize>,
    ) -> Result<(), Fault> {
        let Some(shapes) = self.shapes.clone() else {
            return Ok(());
        };
        let collider = shapes.collider(node).map_err(|text| Fault::format(format!("{label} {text}")))?;
        let Some(collider) = collider else {
            return Ok(());
        };
        let mut name = node.name.as_deref().unwrap_or_default();
        if let (Geometry::Mesh(mesh), "") = (&collider.geometry, name) {
            let record = self.data.document.meshes.get(*mesh as usize);
            name = record.and_then(|record| record.name.as_deref()).unwrap_or_default();
        }
        if let Geometry::Unusable(text) = &collider.geometry {
            self.findings.add_unusable(label, text);
            return Ok(());
        }
        self.claim(name.len(), 1)?;
        self.begin_object(name);
        self.findings.count += 1;
        match &collider.geometry {
            Geometry::Points(points) => {
                let at = |index: usize| points.get(index).copied().unwrap_or_default();
                let (first, count) = self.place(points.len(), at, transform)?;
                self.mesh.loose.extend(first..first + count as u32);
                self.findings.add_points(points.len());
            }
            Geometry::Mesh(mesh) => self.add_collider_mesh(*mesh, label, transform)?,
            Geometry::Node(root) => self.add_meshes_below(*root, label, transform)?,
            Geometry::Unusable(_) => {}
        }
        if !collider.is_convex && !matches!(collider.geometry, Geometry::Points(_)) {
            self.findings.add_concave(name);
        }
        if let Some(object) = self.mesh.objects.len().checked_sub(1) {
            self.mesh.colliders.push(SourceCollider { object, stands_for });
        }
        Ok(())
    }

    fn add_collider_mesh(&mut self, mesh: u32, label: &str, transform: DAffine3) -> Result<(), Fault> {
        let document = self.data.document;
        let Some(record) = document.meshes.get(mesh as usize) else {
            return Err(Fault::format(format!(
                "{label} has a collider with the mesh index {mesh}, which is out of range (the file has {}); export the file again",
                counted(document.meshes.len(), "mesh", "meshes")
            )));
        };
        self.findings.meshes.insert(mesh);
        self.add_primitives(record, label, mesh, transform)
    }

    /// Adds the meshes of a node and of the nodes below it, in the frame of that node.
    fn add_meshes_below(&mut self, root: u32, label: &str, transform: DAffine3) -> Result<(), Fault> {
        let nodes = &self.data.document.nodes;
        let mut visited = HashSet::new();
        let mut stack = vec![(root, transform)];
        while let Some((index, transform)) = stack.pop() {
            let Some(node) = nodes.get(index as usize) else {
                return Err(Fault::format(format!(
                    "{label} has a collider with the node index {index}, which is out of range (the file has {}); export the file again",
                    counted(nodes.len(), "node", "nodes")
                )));
            };
            // Many colliders may refer to one large tree.
            self.claim(1, NODE_BYTES)?;
            if !visited.insert(index) {
                return Err(Fault::format(format!(
                    "{label} has a collider with a cycle of nodes; export the file again"
                )));
            }
            if let Some(mesh) = node.mesh {
                self.add_collider_mesh(mesh, label, transform)?;
            }
            for &child in node.children.iter().rev() {
                let below = nodes.get(child as usize).map_or(Ok(DAffine3::IDENTITY), local);
                let below = below.map_err(|text| Fault::format(format!("node {child} {text}")))?;
                stack.push((child, transform * below));
            }
        }
        Ok(())
    }
}
