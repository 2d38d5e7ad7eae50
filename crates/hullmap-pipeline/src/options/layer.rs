//! Options as given by one source: the command line, `hullmap.toml` (for all meshes, or in a rule),
//! or a pack's record.

use super::removed::instead_of_option;
use hullmap_format::header::FileKind;

use super::table::{Group, OPTION_COUNT, OPTIONS, Scope, position};
use super::value::Value;

/// The options that one source gives, in the order of the table; `None` for those it leaves out.
#[derive(Clone, Debug, PartialEq)]
pub struct OptionLayer {
    pub(super) values: [Option<Value>; OPTION_COUNT],
}

impl Default for OptionLayer {
    /// No option is set.
    fn default() -> Self {
        Self { values: [const { None }; OPTION_COUNT] }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Clash {
    pub key: &'static str,
    other: &'static str,
    kind: ClashKind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ClashKind {
    /// Only one of the two may be given.
    Exclusive,
    /// `other` is false, so that `key` has no effect.
    SwitchedOff,
    /// `key` has no effect without `other`.
    NoEffect,
    /// `key` shapes other contents than `other` writes.
    OfOthers,
}

impl Clash {
    pub(super) fn without(other: &'static str, key: &'static str) -> Self {
        Self { key, other, kind: ClashKind::NoEffect }
    }

    pub(super) fn of_others(key: &'static str, kind: FileKind) -> Self {
        let other = if kind == FileKind::HeightField { "terrain" } else { "keep_triangles" };
        Self { key, other, kind: ClashKind::OfOthers }
    }

    /// The error and its remedy; `name` turns a key into the option's name as it was written.
    pub fn message(&self, name: impl Fn(&str) -> String) -> String {
        let (key, other) = (name(self.key), name(self.other));
        match self.kind {
            ClashKind::Exclusive => format!("{key} and {other} exclude each other; remove one of them"),
            ClashKind::SwitchedOff => format!("{key} has no effect because {other} is false; remove one of them"),
            ClashKind::OfOthers => {
                format!("{key} has no effect with {other}, which writes no hulls; remove one of them")
            }
            ClashKind::NoEffect => format!("{key} has no effect without {other}; add it, or remove {key}"),
        }
    }
}

impl OptionLayer {
    pub fn get(&self, key: &str) -> Option<Value> {
        self.values[position(key)?].clone()
    }

    pub fn value_at(&self, index: usize) -> Option<Value> {
        self.values[index].clone()
    }

    pub fn set_at(&mut self, index: usize, value: Option<Value>) {
        self.values[index] = value;
    }

    pub fn set(&mut self, key: &str, text: &str) -> Result<(), String> {
        let unknown = || instead_of_option(key).map_or_else(|| format!("unknown option {key}"), str::to_owned);
        let index = position(key).ok_or_else(unknown)?;
        self.values[index] = Some(OPTIONS[index].parse(text)?);
        Ok(())
    }

    pub fn decompose(&self) -> Option<bool> {
        match self.get("decompose") {
            Some(Value::Switch(is_on)) => Some(is_on),
            _ => None,
        }
    }

    /// Kind of file that a source with these options becomes.
    pub fn kind(&self) -> FileKind {
        let is_on = |key: &str| self.get(key) == Some(Value::Switch(true));
        match (is_on("terrain"), is_on("keep_triangles")) {
            (true, _) => FileKind::HeightField,
            (false, true) => FileKind::TriangleMesh,
            (false, false) => FileKind::Pack,
        }
    }

    pub(super) fn first(&self, is_meant: impl Fn(Scope) -> bool) -> Option<&'static str> {
        let mut given = OPTIONS.iter().zip(&self.values).filter(|(_, value)| value.is_some());
        given.find(|(option, _)| is_meant(option.scope)).map(|(option, _)| option.key)
    }

    /// The first option of this layer that does not apply to this kind of file.
    pub(super) fn first_option_of_others(&self, kind: FileKind) -> Option<&'static str> {
        // Defaults of the terrains of a folder are no mistake in its other files.
        self.first(|scope| scope != Scope::Terrains && !scope.includes(kind))
    }

    /// The first option of this layer that only applies to decomposed meshes.
    pub fn first_option_of_parts(&self) -> Option<&'static str> {
        self.first(|scope| scope == Scope::Parts)
    }

    /// Two contradicting options of this layer. Between layers, the upper one wins.
    pub fn clash(&self) -> Option<Clash> {
        let is_set = |key| self.get(key).is_some();
        let clash = |key, other, kind| Some(Clash { key, other, kind });
        let kind = self.kind();
        if kind != FileKind::Pack
            && let Some(key) = self.first_option_of_others(kind)
        {
            Some(Clash::of_others(key, kind))
        } else if is_set("max_vertices") && is_set("max_error") && self.decompose() != Some(true) {
            clash("max_error", "max_vertices", ClashKind::Exclusive)
        } else if self.decompose() == Some(false) {
            clash(self.first_option_of_parts()?, "decompose", ClashKind::SwitchedOff)
        } else {
            None
        }
    }

    /// This layer laid over `lower`. Options of one [`Group`] are replaced together.
    #[must_use]
    pub fn laid_over(&self, lower: &Self) -> Self {
        let mut result = self.clone();
        for (index, option) in OPTIONS.iter().enumerate() {
            let is_replaced = option.group != Group::Single && self.gives_any_of(option.group);
            if !is_replaced {
                result.values[index] = self.values[index].clone().or_else(|| lower.values[index].clone());
            }
        }
        result
    }

    fn gives_any_of(&self, group: Group) -> bool {
        OPTIONS.iter().zip(&self.values).any(|(option, value)| option.group == group && value.is_some())
    }
}

#[cfg(test)]
pub mod tests {
    use hullmap_bake::simplify::Limit;

    use super::*;

    pub const VALUES: [(&str, &str); OPTION_COUNT] = [
        ("split", "auto"),
        ("vertices", "all"),
        ("index", "compact"),
        ("unit_scale", "0.01"),
        ("up_axis", "y-to-z"),
        ("recentre", "true"),
        ("decompose", "true"),
        ("max_vertices", "64"),
        ("max_error", "0.5"),
        ("pack_names", "full"),
        ("max_parts", "9"),
        ("solid", "walls"),
        ("wall", "1%"),
        ("decompose_seconds", "2.5"),
        ("record_source", "name"),
        ("lean", "true"),
        ("for_engine", "box3d"),
        ("primitives", "true"),
        ("keep_triangles", "true"),
        ("terrain", "true"),
        ("spacing", "2,3"),
        ("height_scale", "-0.1"),
        ("height_offset", "-1e-300"),
        ("origin", "-5.25,700000"),
        ("hole", "-3.402823e+38"),
        ("hole_image", "holes of a x.png"),
        ("rows", "17"),
        ("columns", "4096"),
        ("diagonal", "falling"),
    ];

    pub fn layer(pairs: &[(&str, &str)]) -> OptionLayer {
        let mut layer = OptionLayer::default();
        for (key, value) in pairs {
            layer.set(key, value).unwrap_or_else(|error| panic!("{key} {value}: {error}"));
        }
        layer
    }

    #[test]
    fn every_option_can_be_set_and_shows_through_an_empty_layer() {
        assert_eq!(OPTIONS.each_ref().map(|option| option.key), VALUES.map(|(key, _)| key));
        for pair in VALUES {
            let one = layer(&[pair]);
            assert_ne!(one, OptionLayer::default(), "{pair:?}");
            assert_eq!(OptionLayer::default().laid_over(&one), one, "{pair:?}");
            assert_eq!(one.laid_over(&OptionLayer::default()), one, "{pair:?}");
        }
    }

    #[test]
    fn groups_are_replaced_together() {
        let few = layer(&[("max_vertices", "8")]);
        let near = layer(&[("max_error", "0.5")]).laid_over(&few);
        assert_eq!(near.resolve().simplify(1.0), Some(Limit::Distance(0.5)));
        for limit in ["max_vertices", "max_error"] {
            assert_eq!(layer(&[(limit, "none")]).laid_over(&near).resolve().simplify(1.0), None);
        }
        let parts = layer(&[("max_parts", "32")]);
        assert_eq!(parts.resolve().decompose(), None, "parameters alone do not decompose");
        let parts = layer(&[("decompose", "true")]).laid_over(&parts).resolve().decompose().unwrap();
        assert_eq!(parts.max_parts, Some(32));
    }
}
