//! glTF 1.0: recognised, so that the error can name it.

use serde::Deserialize;
use serde_json::value::RawValue;

/// Decides by the version, or without one, which 1.0 allows, by objects in place of lists.
pub fn is_version_1(text: &[u8]) -> bool {
    let Ok(document) = serde_json::from_slice::<Document>(text) else {
        return false;
    };
    let version = document.asset.and_then(|asset| asset.version).map_or("", RawValue::get);
    if let Some(text) = version.strip_prefix('"') {
        return text.starts_with("1.") || text.starts_with("0.");
    }
    let collections = [document.scenes, document.nodes, document.meshes, document.accessors, document.buffers];
    let has_objects = || collections.into_iter().flatten().any(|collection| collection.get().starts_with('{'));
    version.parse().map_or_else(|_| has_objects(), |version: f64| (0.0..2.0).contains(&version))
}

#[derive(Deserialize)]
struct Document<'a> {
    #[serde(borrow)]
    asset: Option<Asset<'a>>,
    scenes: Option<&'a RawValue>,
    nodes: Option<&'a RawValue>,
    meshes: Option<&'a RawValue>,
    accessors: Option<&'a RawValue>,
    buffers: Option<&'a RawValue>,
}

#[derive(Deserialize)]
struct Asset<'a> {
    #[serde(borrow)]
    version: Option<&'a RawValue>,
}
