//! glTF 2.0: the properties of a document that affect a hull. Everything else is skipped.
//!
//! Names and data URIs are borrowed from the text. The length of every list is limited while it is
//! read. Integers may be written as `1.0`, as some exporters do.

use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

use serde::Deserialize;
use serde::de::{Deserializer, Error as _, IgnoredAny, SeqAccess, Unexpected, Visitor};

use serde_json::value::RawValue;

use crate::limits::GLTF_LIST;

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Document<'a> {
    #[serde(borrow)]
    pub asset: Asset<'a>,
    #[serde(borrow, default)]
    pub extensions_required: Bounded<Cow<'a, str>>,
    #[serde(borrow, default)]
    pub extensions_used: Bounded<Cow<'a, str>>,
    #[serde(default, deserialize_with = "optional_whole")]
    pub scene: Option<u32>,
    #[serde(default)]
    pub scenes: Bounded<Scene>,
    #[serde(borrow, default)]
    pub nodes: Bounded<Node<'a>>,
    #[serde(borrow, default)]
    pub meshes: Bounded<MeshRecord<'a>>,
    /// Kept as text: a malformed list of materials does not hide the meshes.
    #[serde(borrow)]
    pub materials: Option<&'a RawValue>,
    #[serde(default)]
    pub accessors: Bounded<Accessor>,
    #[serde(default)]
    pub buffer_views: Bounded<BufferView>,
    #[serde(borrow, default)]
    pub buffers: Bounded<Buffer<'a>>,
    #[serde(borrow)]
    pub extensions: Option<Box<DocumentExtensions<'a>>>,
}

/// Text that is parsed only where it is used: malformed extensions do not hide the meshes.
#[derive(Debug, Deserialize)]
pub struct DocumentExtensions<'a> {
    #[serde(borrow, rename = "KHR_implicit_shapes")]
    pub khr_shapes: Option<&'a RawValue>,
    #[serde(borrow, rename = "OMI_physics_shape")]
    pub omi_shapes: Option<&'a RawValue>,
}

#[derive(Debug, Deserialize)]
pub struct Asset<'a> {
    #[serde(borrow)]
    pub version: Cow<'a, str>,
}

#[derive(Debug, Deserialize)]
pub struct Scene {
    #[serde(default, deserialize_with = "whole_list")]
    pub nodes: Bounded<u32>,
}

#[derive(Debug, Deserialize)]
pub struct Node<'a> {
    #[serde(borrow)]
    pub name: Option<Cow<'a, str>>,
    #[serde(default, deserialize_with = "optional_whole")]
    pub mesh: Option<u32>,
    pub skin: Option<IgnoredAny>,
    #[serde(default, deserialize_with = "whole_list")]
    pub children: Bounded<u32>,
    /// Column by column.
    pub matrix: Option<Box<[f64; 16]>>,
    pub translation: Option<[f64; 3]>,
    /// x, y, z, w.
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
    #[serde(borrow)]
    pub extensions: Option<Box<NodeExtensions<'a>>>,
}

#[derive(Debug, Deserialize)]
pub struct NodeExtensions<'a> {
    #[serde(borrow, rename = "KHR_physics_rigid_bodies")]
    pub khr_body: Option<&'a RawValue>,
    #[serde(borrow, rename = "OMI_physics_body")]
    pub omi_body: Option<&'a RawValue>,
}

#[derive(Debug, Deserialize)]
pub struct MeshRecord<'a> {
    #[serde(borrow)]
    pub name: Option<Cow<'a, str>>,
    #[serde(borrow, default)]
    pub primitives: Bounded<Primitive<'a>>,
}

#[derive(Debug, Deserialize)]
pub struct Primitive<'a> {
    #[serde(default)]
    pub attributes: Attributes,
    #[serde(default, deserialize_with = "optional_whole")]
    pub indices: Option<u32>,
    #[serde(default, deserialize_with = "optional_whole")]
    pub mode: Option<u32>,
    /// Index of the material, as text, like the list of materials.
    #[serde(borrow)]
    pub material: Option<&'a RawValue>,
    pub targets: Option<IgnoredAny>,
    #[serde(default)]
    pub extensions: PrimitiveExtensions,
}

#[derive(Debug, Deserialize)]
struct Material<'a> {
    #[serde(borrow)]
    name: Option<Cow<'a, str>>,
}

impl Document<'_> {
    /// Empty where a material has none. No names if the list is malformed.
    pub fn material_names(&self) -> Vec<String> {
        let list = self.materials.and_then(|text| serde_json::from_str::<Bounded<Material>>(text.get()).ok());
        let name = |material: Material| material.name.map_or_else(String::new, Cow::into_owned);
        list.map_or_else(Vec::new, |list| list.0.into_iter().map(name).collect())
    }
}

impl Primitive<'_> {
    /// Index of the material. An index that is not a whole number counts as no material.
    pub fn material_index(&self) -> Option<u32> {
        let text = self.material?.get();
        (text != "null").then(|| serde_json::from_str::<Whole<u32>>(text).map_or(u32::MAX, |index| index.0))
    }
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
pub struct Attributes {
    #[serde(rename = "POSITION", default, deserialize_with = "optional_whole")]
    pub position: Option<u32>,
}

#[derive(Debug, Default, Deserialize)]
pub struct PrimitiveExtensions {
    #[serde(rename = "KHR_draco_mesh_compression")]
    pub draco: Option<Draco>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Draco {
    #[serde(deserialize_with = "whole")]
    pub buffer_view: u32,
    #[serde(default)]
    pub attributes: Attributes,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Accessor {
    #[serde(default, deserialize_with = "optional_whole")]
    pub buffer_view: Option<u32>,
    #[serde(default, deserialize_with = "whole")]
    pub byte_offset: u64,
    #[serde(deserialize_with = "whole")]
    pub component_type: u32,
    #[serde(default)]
    pub normalized: bool,
    #[serde(deserialize_with = "whole")]
    pub count: u64,
    #[serde(rename = "type")]
    pub kind: Kind,
    pub sparse: Option<Box<Sparse>>,
}

/// Type of an accessor's elements.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
pub enum Kind {
    #[serde(rename = "SCALAR")]
    Scalar,
    #[serde(rename = "VEC3")]
    Vec3,
    #[serde(other)]
    Other,
}

impl Kind {
    pub fn name(self) -> &'static str {
        match self {
            Self::Scalar => "SCALAR",
            Self::Vec3 => "VEC3",
            Self::Other => "another",
        }
    }
}

#[derive(Debug, Deserialize)]
pub struct Sparse {
    #[serde(deserialize_with = "whole")]
    pub count: u64,
    pub indices: SparseIndices,
    pub values: SparseValues,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SparseIndices {
    #[serde(deserialize_with = "whole")]
    pub buffer_view: u32,
    #[serde(default, deserialize_with = "whole")]
    pub byte_offset: u64,
    #[serde(deserialize_with = "whole")]
    pub component_type: u32,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SparseValues {
    #[serde(deserialize_with = "whole")]
    pub buffer_view: u32,
    #[serde(default, deserialize_with = "whole")]
    pub byte_offset: u64,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct BufferView {
    #[serde(deserialize_with = "whole")]
    pub buffer: u32,
    #[serde(default, deserialize_with = "whole")]
    pub byte_offset: u64,
    #[serde(deserialize_with = "whole")]
    pub byte_length: u64,
    #[serde(default, deserialize_with = "optional_whole")]
    pub byte_stride: Option<u64>,
    #[serde(default)]
    pub extensions: ViewExtensions,
}

#[derive(Debug, Default, Deserialize)]
pub struct ViewExtensions {
    #[serde(rename = "EXT_meshopt_compression")]
    pub ext_meshopt: Option<Box<Meshopt>>,
    #[serde(rename = "KHR_meshopt_compression")]
    pub khr_meshopt: Option<Box<Meshopt>>,
}

impl ViewExtensions {
    pub fn compression(&self) -> Option<(&'static str, &Meshopt)> {
        let khr = self.khr_meshopt.as_deref().map(|data| ("KHR_meshopt_compression", data));
        khr.or(self.ext_meshopt.as_deref().map(|data| ("EXT_meshopt_compression", data)))
    }
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Meshopt {
    #[serde(deserialize_with = "whole")]
    pub buffer: u32,
    #[serde(default, deserialize_with = "whole")]
    pub byte_offset: u64,
    #[serde(deserialize_with = "whole")]
    pub byte_length: u64,
    #[serde(deserialize_with = "whole")]
    pub byte_stride: u64,
    #[serde(deserialize_with = "whole")]
    pub count: u64,
    pub mode: Mode,
    #[serde(default)]
    pub filter: Filter,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "UPPERCASE")]
pub enum Mode {
    Attributes,
    Triangles,
    Indices,
    #[serde(other)]
    Other,
}

#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "UPPERCASE")]
pub enum Filter {
    #[default]
    None,
    Exponential,
    #[serde(other)]
    Other,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Buffer<'a> {
    #[serde(borrow)]
    pub uri: Option<Cow<'a, str>>,
    #[serde(deserialize_with = "whole")]
    pub byte_length: u64,
}

/// A list of at most [`GLTF_LIST`] entries.
#[derive(Debug)]
pub struct Bounded<T>(pub Vec<T>);

impl<T> Default for Bounded<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> std::ops::Deref for Bounded<T> {
    type Target = [T];
    fn deref(&self) -> &[T] {
        &self.0
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Bounded<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ListVisitor<T>(PhantomData<T>);

        impl<'de, T: Deserialize<'de>> Visitor<'de> for ListVisitor<T> {
            type Value = Bounded<T>;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a list")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Bounded<T>, A::Error> {
                let mut entries = Vec::new();
                while let Some(entry) = list.next_element()? {
                    if entries.len() == GLTF_LIST {
                        return Err(A::Error::custom(format_args!(
                            "a list of more than {GLTF_LIST} entries; split the file"
                        )));
                    }
                    entries.push(entry);
                }
                Ok(Bounded(entries))
            }
        }

        deserializer.deserialize_seq(ListVisitor(PhantomData))
    }
}

/// A whole number of at least 0, written as an integer or as a float such as `1.0`.
struct Whole<T>(T);

impl<'de, T: TryFrom<u64>> Deserialize<'de> for Whole<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct WholeVisitor<T>(PhantomData<T>);

        impl<T: TryFrom<u64>> Visitor<'_> for WholeVisitor<T> {
            type Value = Whole<T>;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                write!(f, "a whole number of at least 0 and at most {} bits", 8 * size_of::<T>())
            }

            fn visit_u64<E: serde::de::Error>(self, number: u64) -> Result<Whole<T>, E> {
                let whole = T::try_from(number).map(Whole);
                whole.map_err(|_| E::invalid_value(Unexpected::Unsigned(number), &self))
            }

            fn visit_f64<E: serde::de::Error>(self, number: f64) -> Result<Whole<T>, E> {
                // Conversion saturates, and so the comparison fails for every number out of range,
                // except 2^64, which becomes 2^64 - 1. No file has as many bytes.
                let whole = number as u64;
                let is_whole = whole as f64 == number;
                match T::try_from(whole) {
                    Ok(whole) if is_whole => Ok(Whole(whole)),
                    _ => Err(E::invalid_value(Unexpected::Float(number), &self)),
                }
            }
        }

        deserializer.deserialize_any(WholeVisitor(PhantomData))
    }
}

fn whole<'de, D: Deserializer<'de>, T: TryFrom<u64>>(deserializer: D) -> Result<T, D::Error> {
    Whole::deserialize(deserializer).map(|whole| whole.0)
}

fn optional_whole<'de, D: Deserializer<'de>, T: TryFrom<u64>>(deserializer: D) -> Result<Option<T>, D::Error> {
    Option::<Whole<T>>::deserialize(deserializer).map(|whole| whole.map(|whole| whole.0))
}

fn whole_list<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Bounded<u32>, D::Error> {
    let list = Bounded::<Whole<u32>>::deserialize(deserializer)?;
    Ok(Bounded(list.0.into_iter().map(|whole| whole.0).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_may_be_floats() {
        let parse = |text: &str| serde_json::from_str::<Whole<u32>>(text).map(|whole| whole.0);
        for (text, expected) in
            [("0", 0), ("7", 7), ("7.0", 7), ("-0.0", 0), ("5.126e3", 5126), ("4294967295.0", u32::MAX)]
        {
            assert_eq!(parse(text).unwrap(), expected, "{text}");
        }
        for text in ["-1", "-1.0", "0.5", "1e300", "4294967296", "4294967296.0", "\"1\"", "null", "[1]", "true"] {
            let error = parse(text).unwrap_err().to_string();
            assert!(error.contains("whole number") && error.contains("32 bits"), "{text}: {error}");
        }
    }
}
