//! Reading and editing of a description in any format: the root element decides.

use std::path::{Path, PathBuf};

use crate::description::{Change, Description, Format};
use crate::document::Document;
use crate::edit::Edit;
use crate::error::RobotError;
use crate::places::Places;
use crate::{mjcf, sdf, urdf};

impl Description {
    /// Reads a description, and finds the files that it names.
    ///
    /// # Errors
    /// A file cannot be read or is invalid, or names are used twice. A missing mesh is no error
    /// here: see [`MeshUse::file`](crate::MeshUse::file).
    pub fn read(path: &Path, places: &Places) -> Result<Self, RobotError> {
        let document = Document::read(path)?;
        let tree = document.parse()?;
        let root = tree.root_element();
        if let Some(node) = tree.descendants().find(|node| is_xacro(*node, &document)) {
            let message = format!(
                "has macros of xacro; expand them first: xacro {} > {}",
                path.display(),
                expanded(path).display()
            );
            return Err(document.error(node.range().start, message));
        }
        let (name, at) = (root.tag_name().name().to_owned(), root.range().start);
        drop(tree);
        match name.as_str() {
            "robot" => urdf::read(document, places),
            "mujoco" => mjcf::read(document, places),
            "sdf" | "gazebo" => sdf::read(document, places),
            "mujocoinclude" => {
                let message = "is a part of a model; name the file that includes it";
                Err(document.error(at, message))
            }
            name => Err(document
                .error(at, format!("`{name}` is not the root of a URDF (robot), MJCF (mujoco) or SDF (sdf) file"))),
        }
    }

    /// The bytes of each document after changes. Whatever is not a collision keeps its bytes.
    ///
    /// # Errors
    /// The encoding of a file cannot express a name.
    ///
    /// # Panics
    /// An index of a change is out of range, or a shape is changed twice.
    pub fn changed(&self, changes: &[Change]) -> Result<Vec<Vec<u8>>, RobotError> {
        let edits = match self.format {
            Format::Urdf => vec![urdf::DIALECT.edits(&self.documents[0], &self.links, changes)?],
            Format::Sdf => vec![sdf::DIALECT.edits(&self.documents[0], &self.links, changes)?],
            Format::Mjcf => mjcf::edits(self, changes)?,
        };
        let apply = |(document, edits): (&Document, Vec<Edit>)| document.edited(edits);
        self.documents.iter().zip(edits).map(apply).collect()
    }
}

/// `arm.urdf` for `arm.xacro` and `arm.urdf.xacro`, `arm_expanded.urdf` for `arm.urdf`.
fn expanded(path: &Path) -> PathBuf {
    let stem = path.with_extension("");
    if path.extension().is_some_and(|extension| extension == "xacro") {
        return stem.with_extension("urdf");
    }
    let name = stem.file_name().unwrap_or_default().to_string_lossy().into_owned();
    stem.with_file_name(format!("{name}_expanded.urdf"))
}

fn is_xacro(node: roxmltree::Node, document: &Document) -> bool {
    node.is_element() && document.text()[node.range().start + 1..].starts_with("xacro:")
}
