//! Where a mesh of a model comes from: a file, or the attributes `vertex` and `face` of `mesh`.
//!
//! # Reference
//! <https://mujoco.readthedocs.io/en/stable/XMLreference.html#asset-mesh-vertex>

use std::str::FromStr;
use std::sync::Arc;

use roxmltree::Node;

use crate::places::InlineMesh;

/// The source that a mesh asset states.
pub enum Source<'a> {
    File(&'a str),
    Inline(Arc<InlineMesh>),
    /// Invalid numbers, with the cause and the remedy.
    Invalid(String),
    /// Neither a file nor vertices.
    Other,
}

impl Source<'_> {
    /// The mesh of an asset without a file.
    pub fn without_file(asset: Node, name: &str) -> Self {
        let Some(vertices) = asset.attribute("vertex") else { return Self::Other };
        let read = || {
            let vertices = triples::<f32>(vertices).filter(|all| all.as_flattened().iter().all(|x| x.is_finite()))?;
            let triangles = triples::<u32>(asset.attribute("face").unwrap_or_default())?;
            let is_inside = triangles.as_flattened().iter().all(|&index| (index as usize) < vertices.len());
            (!vertices.is_empty() && is_inside).then_some((vertices, triangles))
        };
        match read() {
            Some((vertices, triangles)) => {
                Self::Inline(Arc::new(InlineMesh { name: name.to_owned(), vertices, triangles }))
            }
            None => {
                let expected =
                    "expected three finite numbers for each vertex, and three indices of vertices for each face";
                Self::Invalid(format!("mesh `{name}` is invalid; {expected}"))
            }
        }
    }
}

/// Numbers in threes; `None` for anything else.
fn triples<T: FromStr + Copy>(text: &str) -> Option<Vec<[T; 3]>> {
    let numbers: Vec<T> = text.split_whitespace().map(|word| word.parse().ok()).collect::<Option<_>>()?;
    let (triples, rest) = numbers.as_chunks::<3>();
    rest.is_empty().then(|| triples.to_vec())
}
