//! glTF 1.0: recognised, so that the error can name it.

use std::fmt;

use serde::Deserialize;
use serde::de::{Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};

/// Decides by the version, or without one, which 1.0 allows, by objects in place of lists.
pub fn is_version_1(text: &[u8]) -> bool {
    let Ok(document) = serde_json::from_slice::<Document>(text) else {
        return false;
    };
    let version = document.asset.and_then(|asset| asset.version);
    let collections = [document.scenes, document.nodes, document.meshes, document.accessors, document.buffers];
    match version {
        Some(Outline::Number(version)) => (0.0..2.0).contains(&version),
        Some(Outline::Text(version)) => version.starts_with("1.") || version.starts_with("0."),
        _ => collections.iter().any(|collection| matches!(collection, Some(Outline::Object))),
    }
}

#[derive(Deserialize)]
struct Document {
    asset: Option<Asset>,
    scenes: Option<Outline>,
    nodes: Option<Outline>,
    meshes: Option<Outline>,
    accessors: Option<Outline>,
    buffers: Option<Outline>,
}

#[derive(Deserialize)]
struct Asset {
    version: Option<Outline>,
}

enum Outline {
    Object,
    Number(f64),
    Text(String),
    Other,
}

impl<'de> Deserialize<'de> for Outline {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct OutlineVisitor;

        impl<'de> Visitor<'de> for OutlineVisitor {
            type Value = Outline;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("any value")
            }

            fn visit_bool<E>(self, _: bool) -> Result<Outline, E> {
                Ok(Outline::Other)
            }

            fn visit_i64<E>(self, number: i64) -> Result<Outline, E> {
                Ok(Outline::Number(number as f64))
            }

            fn visit_u64<E>(self, number: u64) -> Result<Outline, E> {
                Ok(Outline::Number(number as f64))
            }

            fn visit_f64<E>(self, number: f64) -> Result<Outline, E> {
                Ok(Outline::Number(number))
            }

            fn visit_str<E>(self, text: &str) -> Result<Outline, E> {
                Ok(Outline::Text(text.to_owned()))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Outline, A::Error> {
                while list.next_element::<IgnoredAny>()?.is_some() {}
                Ok(Outline::Other)
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Outline, A::Error> {
                while map.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
                Ok(Outline::Object)
            }
        }

        deserializer.deserialize_any(OutlineVisitor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn version_1_is_recognised_by_its_version_or_its_objects() {
        for (text, expected) in [
            (r#"{"asset":{"version":"1.0"},"nodes":{"a":{}}}"#, true),
            (r#"{"asset":{"version":1},"nodes":{}}"#, true),
            (r#"{"asset":{"version":0.8}}"#, true),
            (r#"{"meshes":{"a":{"primitives":[]}}}"#, true),
            (r#"{"asset":{},"nodes":{}}"#, true),
            (r#"{"asset":{"version":"2.0"},"nodes":{}}"#, false),
            (r#"{"asset":{"version":"2.0"},"nodes":[{"mesh":-1}]}"#, false),
            (r#"{"nodes":[],"meshes":null}"#, false),
            (r#"{"asset":7}"#, false),
            (r#"{"asset":{"version":true}}"#, false),
            ("[]", false),
            ("{", false),
        ] {
            assert_eq!(is_version_1(text.as_bytes()), expected, "{text}");
        }
    }
}
