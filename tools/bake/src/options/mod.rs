//! The options that shape a bake: everything, other than the source's bytes, that a pack's bytes
//! depend on.
//!
//! | module | concept |
//! |---|---|
//! | [`defaults`] | **the table of all options**: key, accepted values, default, help |
//! | [`value`] | the values that options take, and how they are written |
//! | [`layer`] | options given by one source: command line, `hullmap.toml`, or record |
//! | [`flags`] | a layer as flags of `bake build` |
//! | [`mod@template`] | the `hullmap.toml` that `bake init` writes |
//! | [`record`] | the text by which a pack remembers its options |
//!
//! Layers are laid over each other, then [`OptionLayer::resolve`] fills in the defaults. To add an
//! option, add a row to the table and read it in one of the methods of [`BuildOptions`].

pub mod defaults;
#[cfg(feature = "command")]
mod flags;
pub mod layer;
mod record;
#[cfg(feature = "command")]
mod template;
pub mod value;

use hullmap_bake::decompose::{Cover, Fill, Length, Method, Parameters};
use hullmap_bake::simplify::Limit;
use hullmap_bake::{IndexChoice, IndexKind};
use hullmap_format::{FORMAT_VERSION, LEAN_FORMAT_VERSION};
use hullmap_import::{ImportOptions, Split, UpAxis, Vertices};

#[cfg(feature = "command")]
pub use flags::flag;
pub use layer::OptionLayer;
#[cfg(feature = "command")]
pub use template::template;
use value::Value;

/// Resolved options: those without a value have their defaults, and those that do not apply are
/// reset to them.
///
/// # Panics
/// The methods panic if the table of [`defaults`] gives an option another kind of value than they
/// expect: a fault of the program, which the tests of this module would show.
#[derive(Clone, Debug, PartialEq)]
pub struct BuildOptions(OptionLayer);

/// The path of its source that a pack records.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordSource {
    /// Relative to the pack's folder; the name if that would lead out of the project.
    Relative,
    /// The file name.
    Name,
    /// Nothing.
    None,
}

impl Default for BuildOptions {
    fn default() -> Self {
        OptionLayer::default().resolve()
    }
}

impl BuildOptions {
    /// How the source is read.
    pub fn import(&self) -> ImportOptions {
        ImportOptions {
            split: match self.word("split") {
                "object" => Split::Object,
                "auto" => Split::Auto,
                _ => Split::None,
            },
            vertices: match self.word("vertices") {
                "all" => Vertices::All,
                _ => Vertices::Referenced,
            },
            unit_scale: self.number("unit_scale"),
            up_axis: match self.word("up_axis") {
                "y-to-z" => UpAxis::YToZ,
                "z-to-y" => UpAxis::ZToY,
                _ => UpAxis::Keep,
            },
            recentre: self.switch("recentre"),
        }
    }

    /// Which direction index is built.
    pub fn index(&self) -> IndexChoice {
        match self.0.get("index_budget") {
            Some(Value::Count(bytes_per_vertex)) => IndexChoice::Budget { bytes_per_vertex },
            _ => {
                let kind: IndexKind = self.word("index").parse().expect("the table lists the names of index kinds");
                IndexChoice::Kind(kind.with_resolution(self.count("resolution")))
            }
        }
    }

    /// How meshes are decomposed into convex parts; `None` if they are not.
    pub fn decompose(&self) -> Option<Method> {
        match self.0.get("decompose") {
            Some(Value::Word("cover")) => Some(Method::Cover(Cover {
                max_error: self.max_error().unwrap_or(Cover::default().max_error),
                max_parts: self.optional_count("max_parts"),
                max_vertices: self.optional_count("max_vertices").unwrap_or(Cover::default().max_vertices),
                seconds: match self.0.get("decompose_seconds") {
                    Some(Value::Number(seconds)) => Some(seconds),
                    _ => None,
                },
            })),
            Some(Value::Word("vhacd")) => Some(Method::Vhacd(self.vhacd())),
            _ => None,
        }
    }

    fn vhacd(&self) -> Parameters {
        Parameters {
            concavity: self.fraction("vhacd_concavity"),
            resolution: self.count("vhacd_resolution"),
            max_parts: self.count("vhacd_max_parts"),
            alpha: self.fraction("vhacd_alpha"),
            beta: self.fraction("vhacd_beta"),
            plane_downsampling: self.count("vhacd_plane_downsampling"),
            hull_downsampling: self.count("vhacd_hull_downsampling"),
            hull_approximation: self.switch("vhacd_hull_approximation"),
            fill: match self.word("vhacd_fill") {
                "cavities" => Fill::Cavities,
                "surface" => Fill::Surface,
                _ => Fill::Flood,
            },
        }
    }

    /// How far the hull of points with this diagonal is simplified; `None` if it is not. The parts
    /// of a cover are as simple as its limits allow.
    pub fn simplify(&self, diagonal: f64) -> Option<Limit> {
        match (self.0.get("decompose"), self.optional_count("max_vertices"), self.max_error()) {
            (Some(Value::Word("cover")), ..) => None,
            (_, Some(count), _) => Some(Limit::Vertices(count as usize)),
            (_, _, Some(error)) => Some(Limit::Distance(error.of(diagonal))),
            _ => None,
        }
    }

    fn max_error(&self) -> Option<Length> {
        match self.0.get("max_error") {
            Some(Value::Number(error)) => Some(Length::Absolute(error)),
            Some(Value::Percent(percent)) => Some(Length::Relative(percent / 100.0)),
            _ => None,
        }
    }

    fn optional_count(&self, key: &str) -> Option<u32> {
        match self.0.get(key) {
            Some(Value::Count(count)) => Some(count),
            _ => None,
        }
    }

    /// Whether the pack's name keeps the extension of the mesh; `None` if the names of the other
    /// meshes decide.
    pub fn keeps_extension(&self) -> Option<bool> {
        match self.word("pack_names") {
            "stem" => Some(false),
            "full" => Some(true),
            _ => None,
        }
    }

    /// The path of its source that the pack records.
    pub fn record_source(&self) -> RecordSource {
        match self.word("record_source") {
            "name" => RecordSource::Name,
            "none" => RecordSource::None,
            _ => RecordSource::Relative,
        }
    }

    /// Whether packs leave out neighbours, quads, edges, and the faces of large hulls.
    pub fn is_lean(&self) -> bool {
        self.switch("lean")
    }

    /// Format version of the packs.
    pub fn format_version(&self) -> u32 {
        if self.is_lean() { LEAN_FORMAT_VERSION } else { FORMAT_VERSION }
    }

    fn word(&self, key: &str) -> &'static str {
        match self.0.get(key) {
            Some(Value::Word(word)) => word,
            other => unexpected(key, other),
        }
    }

    fn switch(&self, key: &str) -> bool {
        match self.0.get(key) {
            Some(Value::Switch(is_on)) => is_on,
            other => unexpected(key, other),
        }
    }

    fn count(&self, key: &str) -> u32 {
        match self.0.get(key) {
            Some(Value::Count(count)) => count,
            other => unexpected(key, other),
        }
    }

    fn fraction(&self, key: &str) -> f64 {
        match self.0.get(key) {
            Some(Value::Fraction(fraction)) => fraction.into(),
            other => unexpected(key, other),
        }
    }

    fn number(&self, key: &str) -> f64 {
        match self.0.get(key) {
            Some(Value::Number(number)) => number,
            other => unexpected(key, other),
        }
    }
}

fn unexpected(key: &str, value: Option<Value>) -> ! {
    panic!("option {key} has an unexpected kind of value: {value:?}")
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// Options with these values, the others at their defaults.
    pub fn options(pairs: &[(&str, &str)]) -> BuildOptions {
        layer::tests::layer(pairs).resolve()
    }

    fn vhacd(pairs: &[(&str, &str)]) -> Parameters {
        match options(pairs).decompose() {
            Some(Method::Vhacd(parameters)) => parameters,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn defaults_are_those_of_the_libraries() {
        let usual = BuildOptions::default();
        assert_eq!(usual.import(), ImportOptions::DEFAULT);
        assert_eq!(usual.index(), IndexChoice::default());
        assert_eq!((usual.decompose(), usual.simplify(1.0)), (None, None));
        let cover = Some(Method::Cover(Cover::default()));
        assert_eq!(options(&[("decompose", "cover")]).decompose(), cover);
        let parts = vhacd(&[("decompose", "vhacd")]);
        let library = Parameters::default();
        // Fractions are f32 in records.
        let rounded = |x: f64| f64::from(x as f32);
        let expected = Parameters {
            concavity: rounded(library.concavity),
            alpha: rounded(library.alpha),
            beta: rounded(library.beta),
            ..library
        };
        assert_eq!(parts, expected);
    }

    #[test]
    fn every_option_reaches_the_libraries() {
        let import = |key, value| options(&[(key, value)]).import();
        let usual = ImportOptions::DEFAULT;
        assert_eq!(import("split", "auto"), ImportOptions { split: Split::Auto, ..usual });
        assert_eq!(import("split", "object"), ImportOptions { split: Split::Object, ..usual });
        assert_eq!(import("vertices", "all"), ImportOptions { vertices: Vertices::All, ..usual });
        assert_eq!(import("unit_scale", "0.01"), ImportOptions { unit_scale: 0.01, ..usual });
        assert_eq!(import("up_axis", "y-to-z"), ImportOptions { up_axis: UpAxis::YToZ, ..usual });
        assert_eq!(import("up_axis", "z-to-y"), ImportOptions { up_axis: UpAxis::ZToY, ..usual });
        assert_eq!(import("recentre", "true"), ImportOptions { recentre: true, ..usual });
        for kind in IndexKind::NAMED {
            assert_eq!(options(&[("index", kind.as_str())]).index(), kind.into());
        }
        let cubemap = options(&[("index", "cubemap"), ("resolution", "5")]);
        assert_eq!(cubemap.index(), IndexKind::CubeMap { resolution: 5 }.into());
        assert_eq!(options(&[("index_budget", "40")]).index(), IndexChoice::Budget { bytes_per_vertex: 40 });
        assert_eq!(options(&[("max_vertices", "64")]).simplify(3.0), Some(Limit::Vertices(64)));
        assert_eq!(options(&[("max_error", "1e-3")]).simplify(3.0), Some(Limit::Distance(1e-3)));
        let names = ["auto", "stem", "full"].map(|names| options(&[("pack_names", names)]).keeps_extension());
        assert_eq!(names, [None, Some(false), Some(true)]);
        assert_eq!(options(&[("max_error", "1%")]).simplify(3.0), Some(Limit::Distance(0.03)));
        assert!(options(&[("lean", "true")]).is_lean() && !BuildOptions::default().is_lean());
        let cover = |key, value| options(&[("decompose", "cover"), (key, value)]).decompose();
        let usual = Cover::default();
        let is = |cover| Some(Method::Cover(cover));
        assert_eq!(cover("max_error", "0.5"), is(Cover { max_error: Length::Absolute(0.5), ..usual }));
        assert_eq!(cover("max_error", "1%"), is(Cover { max_error: Length::Relative(0.01), ..usual }));
        assert_eq!(cover("max_vertices", "32"), is(Cover { max_vertices: 32, ..usual }));
        assert_eq!(cover("max_parts", "7"), is(Cover { max_parts: Some(7), ..usual }));
        assert_eq!(cover("decompose_seconds", "1.5"), is(Cover { seconds: Some(1.5), ..usual }));
        assert_eq!(options(&[("decompose", "cover"), ("max_vertices", "32")]).simplify(1.0), None);
        let usual = vhacd(&[("decompose", "vhacd")]);
        // Without a name, it is V-HACD.
        let parts = |key, value| vhacd(&[("decompose", "true"), (key, value)]);
        assert_eq!(parts("vhacd_concavity", "0.5"), Parameters { concavity: 0.5, ..usual });
        assert_eq!(parts("vhacd_resolution", "32"), Parameters { resolution: 32, ..usual });
        assert_eq!(parts("vhacd_max_parts", "8"), Parameters { max_parts: 8, ..usual });
        assert_eq!(parts("vhacd_alpha", "0.25"), Parameters { alpha: 0.25, ..usual });
        assert_eq!(parts("vhacd_beta", "0.25"), Parameters { beta: 0.25, ..usual });
        assert_eq!(parts("vhacd_plane_downsampling", "2"), Parameters { plane_downsampling: 2, ..usual });
        assert_eq!(parts("vhacd_hull_downsampling", "2"), Parameters { hull_downsampling: 2, ..usual });
        assert_eq!(parts("vhacd_hull_approximation", "false"), Parameters { hull_approximation: false, ..usual });
        assert_eq!(parts("vhacd_fill", "cavities"), Parameters { fill: Fill::Cavities, ..usual });
        assert_eq!(parts("vhacd_fill", "surface"), Parameters { fill: Fill::Surface, ..usual });
    }
}
