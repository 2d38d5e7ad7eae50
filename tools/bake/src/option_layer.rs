//! What one place says of the options: the command line, the defaults of a `hullmap.toml`, one of its rules, the record
//! in a pack. Each option has one name, one way to be read and one range, wherever it is written.

use hullmap_bake::IndexKind;
use hullmap_import::{ImportOptions, Split, UpAxis, Vertices};

use crate::options::{BuildOptions, DEFAULT_RESOLUTION, DecomposeOptions, Fill, IndexName, MAX_RESOLUTION, Simplify};

/// Options as far as they are said; `None` where this place is silent. As arguments of clap, the flags of `bake build`.
#[derive(Clone, Debug, Default, PartialEq, clap::Args)]
pub struct OptionLayer {
    /// One hull a file, or for each object, or by artists' names (UCX_…)
    #[arg(long, value_enum, value_name = "none|object|auto", hide_possible_values = true)]
    pub split: Option<Split>,
    /// The points that elements reference, or all
    #[arg(long, value_enum, value_name = "referenced|all", hide_possible_values = true)]
    pub vertices: Option<Vertices>,
    /// Multiply coordinates with this
    #[arg(long, value_name = "F", value_parser = unit_scale)]
    pub unit_scale: Option<f64>,
    /// Turn about x: y-to-z makes what points along y point along z
    #[arg(long, value_enum, value_name = "keep|y-to-z|z-to-y", hide_possible_values = true)]
    pub up_axis: Option<UpAxis>,
    /// Take points from the middle of the bounds: for meshes far off
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true)]
    pub recentre: Option<bool>,
    /// The direction index: tree, medium, compact, binary, cubemap or none
    #[arg(long, value_enum, value_name = "KIND", hide_possible_values = true)]
    pub index: Option<IndexName>,
    /// Instead of --index: the fastest of so many bytes a vertex
    #[arg(long, hide_short_help = true, value_name = "BYTES", value_parser = at_least_1, conflicts_with = "index")]
    pub index_budget: Option<u32>,
    /// Cells along the edge of a cube face, 1 to 1024, for --index cubemap
    #[arg(long, hide_short_help = true, value_name = "R", value_parser = resolution)]
    pub resolution: Option<u32>,
    /// An outer hull of at most N vertices, at least 4, or none
    #[arg(long, value_name = "N", value_parser = max_vertices, help_heading = "Simplification")]
    pub max_vertices: Option<Limit<u32>>,
    /// An outer hull that leaves the source by at most E units, or none
    #[arg(long, value_name = "E", value_parser = max_error, conflicts_with = "max_vertices", help_heading = "Simplification")]
    pub max_error: Option<Limit<f64>>,
    /// Cut concave meshes into convex parts (V-HACD)
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true", hide_possible_values = true, help_heading = "Decomposition")]
    pub decompose: Option<bool>,
    /// Volume by which a part may differ from its hull, 0 to 1
    #[arg(long, value_name = "F", value_parser = fraction, hide_short_help = true, help_heading = "Decomposition")]
    pub vhacd_concavity: Option<f32>,
    /// Voxels along the longest side, 1 to 512
    #[arg(long, value_name = "N", value_parser = voxels, hide_short_help = true, help_heading = "Decomposition")]
    pub vhacd_resolution: Option<u32>,
    /// Most parts
    #[arg(long, value_name = "N", value_parser = at_least_1, hide_short_help = true, help_heading = "Decomposition")]
    pub vhacd_max_parts: Option<u32>,
    /// Weight of balanced cuts, 0 to 1
    #[arg(long, value_name = "F", value_parser = fraction, hide_short_help = true, help_heading = "Decomposition")]
    pub vhacd_alpha: Option<f32>,
    /// Weight of cuts through an axis of revolution, 0 to 1
    #[arg(long, value_name = "F", value_parser = fraction, hide_short_help = true, help_heading = "Decomposition")]
    pub vhacd_beta: Option<f32>,
    /// Try every Nth cutting plane, 1 to 16
    #[arg(long, value_name = "N", value_parser = downsampling, hide_short_help = true, help_heading = "Decomposition")]
    pub vhacd_plane_downsampling: Option<u32>,
    /// Make trial hulls of every Nth voxel, 1 to 16
    #[arg(long, value_name = "N", value_parser = downsampling, hide_short_help = true, help_heading = "Decomposition")]
    pub vhacd_hull_downsampling: Option<u32>,
    /// Make trial hulls of voxels rather than of the mesh
    #[arg(
        long,
        value_name = "BOOL",
        hide_short_help = true,
        help_heading = "Decomposition",
        hide_possible_values = true
    )]
    pub vhacd_hull_approximation: Option<bool>,
    /// What is inside: flooded, cavities left out, or the surface alone
    #[arg(
        long,
        value_enum,
        value_name = "flood|cavities|surface",
        hide_short_help = true,
        help_heading = "Decomposition",
        hide_possible_values = true
    )]
    pub vhacd_fill: Option<Fill>,
}

/// A limit, or the word `none`, which takes one away that a lower layer has set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit<T> {
    /// No limit.
    None,
    /// At most this much.
    At(T),
}

/// Kinds of values, as `hullmap.toml` writes them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A string: one of some words.
    Word,
    /// An integer.
    Integer,
    /// An integer or a float.
    Number,
    /// true or false.
    Switch,
    /// An integer, or `"none"`.
    IntegerOrNone,
    /// A number, or `"none"`.
    NumberOrNone,
}

/// The options by name. On the command line `_` is `-`.
pub const KEYS: [(&str, Kind); 20] = [
    ("split", Kind::Word),
    ("vertices", Kind::Word),
    ("unit_scale", Kind::Number),
    ("up_axis", Kind::Word),
    ("recentre", Kind::Switch),
    ("index", Kind::Word),
    ("index_budget", Kind::Integer),
    ("resolution", Kind::Integer),
    ("max_vertices", Kind::IntegerOrNone),
    ("max_error", Kind::NumberOrNone),
    ("decompose", Kind::Switch),
    ("vhacd_concavity", Kind::Number),
    ("vhacd_resolution", Kind::Integer),
    ("vhacd_max_parts", Kind::Integer),
    ("vhacd_alpha", Kind::Number),
    ("vhacd_beta", Kind::Number),
    ("vhacd_plane_downsampling", Kind::Integer),
    ("vhacd_hull_downsampling", Kind::Integer),
    ("vhacd_hull_approximation", Kind::Switch),
    ("vhacd_fill", Kind::Word),
];

/// Why a value was not taken.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ValueError {
    /// No option has that name.
    #[error("no option has this name")]
    UnknownKey,
    /// One of some words was expected.
    #[error("expected one of {}", .0.join(", "))]
    UnknownWord(Vec<String>),
    /// A number out of its range, or none.
    #[error("{0}")]
    Range(String),
}

impl OptionLayer {
    /// Sets the option `key` to what `text` says.
    ///
    /// # Errors
    /// No such option, or a value that it cannot have.
    pub fn set(&mut self, key: &str, text: &str) -> Result<(), ValueError> {
        let range = ValueError::Range;
        match key {
            "split" => self.split = Some(from_word(text)?),
            "vertices" => self.vertices = Some(from_word(text)?),
            "unit_scale" => self.unit_scale = Some(unit_scale(text).map_err(range)?),
            "up_axis" => self.up_axis = Some(from_word(text)?),
            "recentre" => self.recentre = Some(switch(text).map_err(range)?),
            "index" => self.index = Some(from_word(text)?),
            "index_budget" => self.index_budget = Some(at_least_1(text).map_err(range)?),
            "resolution" => self.resolution = Some(resolution(text).map_err(range)?),
            "max_vertices" => self.max_vertices = Some(max_vertices(text).map_err(range)?),
            "max_error" => self.max_error = Some(max_error(text).map_err(range)?),
            "decompose" => self.decompose = Some(switch(text).map_err(range)?),
            "vhacd_concavity" => self.vhacd_concavity = Some(fraction(text).map_err(range)?),
            "vhacd_resolution" => self.vhacd_resolution = Some(voxels(text).map_err(range)?),
            "vhacd_max_parts" => self.vhacd_max_parts = Some(at_least_1(text).map_err(range)?),
            "vhacd_alpha" => self.vhacd_alpha = Some(fraction(text).map_err(range)?),
            "vhacd_beta" => self.vhacd_beta = Some(fraction(text).map_err(range)?),
            "vhacd_plane_downsampling" => self.vhacd_plane_downsampling = Some(downsampling(text).map_err(range)?),
            "vhacd_hull_downsampling" => self.vhacd_hull_downsampling = Some(downsampling(text).map_err(range)?),
            "vhacd_hull_approximation" => self.vhacd_hull_approximation = Some(switch(text).map_err(range)?),
            "vhacd_fill" => self.vhacd_fill = Some(from_word(text)?),
            _ => return Err(ValueError::UnknownKey),
        }
        Ok(())
    }

    /// Two options of this one layer that do not go together, and why; `None` where all do. Between layers nothing
    /// clashes: the upper one wins.
    pub fn clash(&self) -> Option<(&'static str, &'static str)> {
        if self.resolution.is_some() && self.index != Some(IndexName::Cubemap) {
            Some(("resolution", "belongs to index cubemap; leave it out or choose that index in the same place"))
        } else if self.index_budget.is_some() && self.index.is_some() {
            Some(("index_budget", "chooses the index itself; leave out it or index"))
        } else if self.max_vertices.is_some() && self.max_error.is_some() {
            Some(("max_error", "cannot be kept together with max_vertices; leave one out"))
        } else if self.decompose == Some(false) {
            self.first_of_decomposition().map(|key| (key, "applies to nothing where decompose is false; leave one out"))
        } else {
            None
        }
    }

    /// A parameter of the decomposition that is set.
    pub fn first_of_decomposition(&self) -> Option<&'static str> {
        let set = [
            ("vhacd_concavity", self.vhacd_concavity.is_some()),
            ("vhacd_resolution", self.vhacd_resolution.is_some()),
            ("vhacd_max_parts", self.vhacd_max_parts.is_some()),
            ("vhacd_alpha", self.vhacd_alpha.is_some()),
            ("vhacd_beta", self.vhacd_beta.is_some()),
            ("vhacd_plane_downsampling", self.vhacd_plane_downsampling.is_some()),
            ("vhacd_hull_downsampling", self.vhacd_hull_downsampling.is_some()),
            ("vhacd_hull_approximation", self.vhacd_hull_approximation.is_some()),
            ("vhacd_fill", self.vhacd_fill.is_some()),
        ];
        set.into_iter().find_map(|(key, is_set)| is_set.then_some(key))
    }

    /// This layer upon `lower`. What belongs together is replaced together: an index with its resolution or budget,
    /// the two limits of a simplification.
    pub fn over(self, lower: &Self) -> Self {
        let names_index = self.index.is_some() || self.index_budget.is_some();
        let names_limit = self.max_vertices.is_some() || self.max_error.is_some();
        let [index, limit] = [names_index, names_limit].map(|is_named| (!is_named).then_some(lower));
        Self {
            split: self.split.or(lower.split),
            vertices: self.vertices.or(lower.vertices),
            unit_scale: self.unit_scale.or(lower.unit_scale),
            up_axis: self.up_axis.or(lower.up_axis),
            recentre: self.recentre.or(lower.recentre),
            index: self.index.or_else(|| index?.index),
            index_budget: self.index_budget.or_else(|| index?.index_budget),
            resolution: self.resolution.or_else(|| index?.resolution),
            max_vertices: self.max_vertices.or_else(|| limit?.max_vertices),
            max_error: self.max_error.or_else(|| limit?.max_error),
            decompose: self.decompose.or(lower.decompose),
            vhacd_concavity: self.vhacd_concavity.or(lower.vhacd_concavity),
            vhacd_resolution: self.vhacd_resolution.or(lower.vhacd_resolution),
            vhacd_max_parts: self.vhacd_max_parts.or(lower.vhacd_max_parts),
            vhacd_alpha: self.vhacd_alpha.or(lower.vhacd_alpha),
            vhacd_beta: self.vhacd_beta.or(lower.vhacd_beta),
            vhacd_plane_downsampling: self.vhacd_plane_downsampling.or(lower.vhacd_plane_downsampling),
            vhacd_hull_downsampling: self.vhacd_hull_downsampling.or(lower.vhacd_hull_downsampling),
            vhacd_hull_approximation: self.vhacd_hull_approximation.or(lower.vhacd_hull_approximation),
            vhacd_fill: self.vhacd_fill.or(lower.vhacd_fill),
        }
    }

    /// The options, with the defaults where nothing is said.
    pub fn options(&self) -> BuildOptions {
        let usual = ImportOptions::DEFAULT;
        let import = ImportOptions {
            split: self.split.unwrap_or(usual.split),
            vertices: self.vertices.unwrap_or(usual.vertices),
            unit_scale: self.unit_scale.unwrap_or(usual.unit_scale),
            up_axis: self.up_axis.unwrap_or(usual.up_axis),
            recentre: self.recentre.unwrap_or(usual.recentre),
        };
        let parts = DecomposeOptions::DEFAULT;
        let parts = DecomposeOptions {
            concavity: self.vhacd_concavity.unwrap_or(parts.concavity),
            resolution: self.vhacd_resolution.unwrap_or(parts.resolution),
            max_parts: self.vhacd_max_parts.unwrap_or(parts.max_parts),
            alpha: self.vhacd_alpha.unwrap_or(parts.alpha),
            beta: self.vhacd_beta.unwrap_or(parts.beta),
            plane_downsampling: self.vhacd_plane_downsampling.unwrap_or(parts.plane_downsampling),
            hull_downsampling: self.vhacd_hull_downsampling.unwrap_or(parts.hull_downsampling),
            hull_approximation: self.vhacd_hull_approximation.unwrap_or(parts.hull_approximation),
            fill: self.vhacd_fill.unwrap_or(parts.fill),
        };
        let simplify = match (self.max_vertices, self.max_error) {
            (Some(Limit::At(count)), _) => Simplify::MaxVertices(count),
            (_, Some(Limit::At(error))) => Simplify::MaxError(error),
            _ => Simplify::None,
        };
        let resolution = self.resolution.unwrap_or(DEFAULT_RESOLUTION);
        let named = || self.index.map_or(BuildOptions::DEFAULT.index, |name| name.kind(resolution));
        let index = self.index_budget.map_or_else(named, |bytes_per_vertex| IndexKind::Budget { bytes_per_vertex });
        BuildOptions { import, decompose: (self.decompose == Some(true)).then_some(parts), simplify, index }
    }
}

fn from_word<T: clap::ValueEnum>(text: &str) -> Result<T, ValueError> {
    T::from_str(text, false)
        .map_err(|_| ValueError::UnknownWord(T::value_variants().iter().map(crate::options::word).collect()))
}

fn switch(text: &str) -> Result<bool, String> {
    text.parse().map_err(|_| "expected true or false".to_owned())
}

/// The number that `text` states, if it passes `is_good`; NaN is to fail that.
fn number<T: std::str::FromStr>(text: &str, is_good: impl Fn(&T) -> bool, expected: &str) -> Result<T, String> {
    text.parse().ok().filter(is_good).ok_or_else(|| format!("expected {expected}"))
}

fn unit_scale(text: &str) -> Result<f64, String> {
    number(text, |&scale: &f64| scale > 0.0 && scale.is_finite(), "a finite number above 0")
}

fn fraction(text: &str) -> Result<f32, String> {
    // Adding +0 turns −0 into +0, so that equal options have equal texts.
    number(text, |fraction| (0.0..=1.0).contains(fraction), "a number from 0 to 1").map(|fraction: f32| fraction + 0.0)
}

fn at_least_1(text: &str) -> Result<u32, String> {
    number(text, |&count| count >= 1, "a whole number of at least 1")
}

fn resolution(text: &str) -> Result<u32, String> {
    number(text, |count| (1..=MAX_RESOLUTION).contains(count), &format!("a whole number from 1 to {MAX_RESOLUTION}"))
}

fn voxels(text: &str) -> Result<u32, String> {
    let most = DecomposeOptions::MAX_VOXELS;
    number(text, |count| (1..=most).contains(count), &format!("a whole number from 1 to {most}"))
}

fn downsampling(text: &str) -> Result<u32, String> {
    let most = DecomposeOptions::MAX_DOWNSAMPLING;
    number(text, |count| (1..=most).contains(count), &format!("a whole number from 1 to {most}"))
}

fn max_vertices(text: &str) -> Result<Limit<u32>, String> {
    let least = Simplify::MIN_VERTICES;
    let expected = format!("a whole number of at least {least}, or none");
    if text == "none" {
        return Ok(Limit::None);
    }
    number(text, |&count| count >= least, &expected).map(Limit::At)
}

fn max_error(text: &str) -> Result<Limit<f64>, String> {
    if text == "none" {
        return Ok(Limit::None);
    }
    number(text, |&error: &f64| error > 0.0 && error.is_finite(), "a finite length above 0, or none").map(Limit::At)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A value for each option that is not its default.
    const VALUES: [(&str, &str); 20] = [
        ("split", "auto"),
        ("vertices", "all"),
        ("unit_scale", "0.01"),
        ("up_axis", "y-to-z"),
        ("recentre", "true"),
        ("index", "compact"),
        ("index_budget", "40"),
        ("resolution", "5"),
        ("max_vertices", "64"),
        ("max_error", "0.5"),
        ("decompose", "true"),
        ("vhacd_concavity", "0.5"),
        ("vhacd_resolution", "32"),
        ("vhacd_max_parts", "8"),
        ("vhacd_alpha", "0.25"),
        ("vhacd_beta", "0.25"),
        ("vhacd_plane_downsampling", "2"),
        ("vhacd_hull_downsampling", "2"),
        ("vhacd_hull_approximation", "false"),
        ("vhacd_fill", "surface"),
    ];

    fn layer(pairs: &[(&str, &str)]) -> OptionLayer {
        let mut layer = OptionLayer::default();
        for (key, value) in pairs {
            layer.set(key, value).unwrap_or_else(|error| panic!("{key} {value}: {error}"));
        }
        layer
    }

    #[test]
    fn every_key_can_be_set_and_is_kept_by_an_empty_layer_above() {
        assert_eq!(KEYS.map(|(key, _)| key), VALUES.map(|(key, _)| key));
        for pair in VALUES {
            let one = layer(&[pair]);
            assert_ne!(one, OptionLayer::default(), "{pair:?}");
            assert_eq!(OptionLayer::default().over(&one), one, "{pair:?}");
            assert_eq!(one.clone().over(&OptionLayer::default()), one, "{pair:?}");
        }
    }

    #[test]
    fn the_flags_are_the_keys() {
        let command = <OptionLayer as clap::Args>::augment_args(clap::Command::new("x"));
        let flags: Vec<String> =
            command.get_arguments().filter_map(clap::Arg::get_long).map(|flag| flag.replace('-', "_")).collect();
        assert_eq!(flags, KEYS.map(|(key, _)| key));
    }

    #[test]
    fn what_belongs_together_is_replaced_together() {
        let cubemap = layer(&[("index", "cubemap"), ("resolution", "5")]);
        assert_eq!(cubemap.options().index, IndexKind::CubeMap { resolution: 5 });
        assert_eq!(layer(&[("index", "tree")]).over(&cubemap).options().index, IndexKind::TREE);
        let budget = layer(&[("index_budget", "9")]).over(&cubemap);
        assert_eq!(budget.options().index, IndexKind::Budget { bytes_per_vertex: 9 });
        let cubemap = layer(&[("index", "cubemap")]).over(&budget);
        assert_eq!(cubemap.options().index, IndexKind::CubeMap { resolution: DEFAULT_RESOLUTION });
        let few = layer(&[("max_vertices", "8")]);
        let near = layer(&[("max_error", "0.5")]).over(&few);
        assert_eq!(near.options().simplify, Simplify::MaxError(0.5));
        for none in ["max_vertices", "max_error"] {
            assert_eq!(layer(&[(none, "none")]).over(&near).options().simplify, Simplify::None);
        }
        let parts = layer(&[("vhacd_resolution", "32")]);
        assert_eq!(parts.options().decompose, None, "parameters alone ask for nothing");
        let parts = layer(&[("decompose", "true")]).over(&parts).options().decompose.unwrap();
        assert_eq!(parts, DecomposeOptions { resolution: 32, ..DecomposeOptions::DEFAULT });
    }

    #[test]
    fn wrong_values_are_told_the_right_ones() {
        let error = |key: &str, value: &str| OptionLayer::default().set(key, value).unwrap_err().to_string();
        assert_eq!(error("split", "group"), "expected one of none, object, auto");
        assert_eq!(error("up_axis", "Y-to-Z"), "expected one of keep, y-to-z, z-to-y");
        for (key, values) in [
            ("unit_scale", ["0", "-1", "nan", "inf", "x", "1e-400"].as_slice()),
            ("recentre", &["yes", "1"]),
            ("resolution", &["0", "1025", "1.5"]),
            ("index_budget", &["0", "-1"]),
            ("max_vertices", &["3", "many", "-8"]),
            ("max_error", &["0", "-1", "nan", "inf"]),
            ("vhacd_concavity", &["1.1", "-0.1", "nan"]),
            ("vhacd_resolution", &["0", "513"]),
            ("vhacd_max_parts", &["0"]),
            ("vhacd_plane_downsampling", &["0", "17"]),
        ] {
            for value in values {
                assert!(error(key, value).starts_with("expected "), "{key} {value}");
            }
        }
        assert_eq!(OptionLayer::default().set("units", "1"), Err(ValueError::UnknownKey));
    }

    #[test]
    fn clashes_are_within_a_layer() {
        assert_eq!(layer(&[("resolution", "5")]).clash().map(|clash| clash.0), Some("resolution"));
        assert_eq!(
            layer(&[("index", "tree"), ("index_budget", "5")]).clash().map(|clash| clash.0),
            Some("index_budget")
        );
        assert_eq!(layer(&[("max_error", "5"), ("max_vertices", "5")]).clash().map(|clash| clash.0), Some("max_error"));
        assert_eq!(layer(&[("index", "cubemap"), ("resolution", "5")]).clash(), None);
        let parameters: Vec<_> = VALUES.into_iter().filter(|(key, _)| key.starts_with("vhacd_")).collect();
        for (key, value) in parameters {
            assert_eq!(layer(&[("decompose", "false"), (key, value)]).clash().map(|clash| clash.0), Some(key));
            assert_eq!(layer(&[("decompose", "true"), (key, value)]).clash(), None);
            // Here the command line, or a rule, may decompose.
            assert_eq!(layer(&[(key, value)]).clash(), None);
        }
    }
}
