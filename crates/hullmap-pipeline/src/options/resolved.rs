//! The options of a bake: a layer whose gaps are filled with the defaults.

use std::sync::Arc;

use hullmap::height_field::{Diagonal, Layout};
use hullmap_bake::IndexKind;
use hullmap_bake::decompose::{Cover, Length, ONE_PART_VERTICES, PART_VERTICES};
use hullmap_bake::fit::SolidRule;
use hullmap_bake::simplify::Limit;
use hullmap_format::header::FileKind;
use hullmap_format::{height_field, triangle_mesh, version};
use hullmap_import::height_field::{HeightOptions, Heights};
use hullmap_import::{ImportOptions, Split, UpAxis, Vertices};

use super::layer::{Clash, OptionLayer};
use super::table::{OPTIONS, Scope, position};
use super::value::Value;
use crate::budget::{Budget, budget};

/// Default thickness of parts, relative to the diagonal: enough for an inside in spite of rounding.
const THINNEST: f64 = 1e-5;

/// An option that has no value, or does not apply, has its default from the
/// [`table`](super::table), or from [`Cover::default`] for decomposed meshes.
///
/// # Panics
/// The methods panic if the [`table`](super::table) has another kind of value: a bug.
#[derive(Clone, Debug, PartialEq)]
pub struct BuildOptions(pub(super) OptionLayer);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordSource {
    /// Relative to the pack's folder; the name if that would lead out of the project.
    Relative,
    Name,
    None,
}

impl OptionLayer {
    pub fn resolve(&self) -> BuildOptions {
        let (mut resolved, kind) = (self.clone(), self.kind());
        for (value, option) in resolved.values.iter_mut().zip(&OPTIONS) {
            let applies =
                option.scope.includes(kind) && (option.scope != Scope::Parts || self.decompose() == Some(true));
            if value.is_none() || !applies {
                *value = Some(option.syntax.parse(option.default).expect("a default is an accepted value"));
            }
        }
        // Only hulls have a direction index.
        if let (true, Some(index)) = (kind != FileKind::Pack, position("index")) {
            resolved.values[index] = Some(Value::Word("none"));
        }
        BuildOptions(resolved)
    }

    /// The first option of this layer that has no effect: it shapes terrains or parts, and none of
    /// `resolved` is a terrain or decomposes. Other layers may have contributed to `resolved`.
    pub fn without_effect<'a>(&self, resolved: impl Iterator<Item = &'a BuildOptions> + Clone) -> Option<Clash> {
        let of_terrains = self.first(|scope| scope == Scope::Terrains);
        let has_terrains = resolved.clone().any(|options| options.file_kind() == FileKind::HeightField);
        if let Some(key) = of_terrains.filter(|_| !has_terrains) {
            return Some(Clash::without("terrain", key));
        }
        let kind = resolved.clone().next().map(BuildOptions::file_kind).filter(|kind| *kind != FileKind::Pack);
        if let Some(kind) = kind.filter(|kind| resolved.clone().all(|options| options.file_kind() == *kind)) {
            return self.first_option_of_others(kind).map(|key| Clash::of_others(key, kind));
        }
        let has_parts = resolved.clone().any(|options| options.switch("decompose"));
        self.first_option_of_parts().filter(|_| !has_parts).map(|key| Clash::without("decompose", key))
    }
}

impl Default for BuildOptions {
    fn default() -> Self {
        OptionLayer::default().resolve()
    }
}

impl BuildOptions {
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

    pub fn index(&self) -> IndexKind {
        self.word("index").parse().expect("the table lists the names of index kinds")
    }

    pub fn decompose(&self) -> Option<Cover> {
        self.switch("decompose").then(|| Cover {
            max_error: self.max_error().unwrap_or(Cover::default().max_error),
            max_parts: self.optional_count("max_parts"),
            max_vertices: match self.optional_count("max_vertices") {
                Some(count) => Some(self.within_budget(count)),
                None if self.within_budget(ONE_PART_VERTICES) == ONE_PART_VERTICES => None,
                None => Some(self.within_budget(PART_VERTICES)),
            },
            solid: SolidRule::ALL
                .into_iter()
                .find(|rule| rule.as_str() == self.word("solid"))
                .expect("the table lists the names of rules"),
            wall: self.length("wall").unwrap_or(Length::Relative(THINNEST)),
            seconds: self.optional_number("decompose_seconds"),
        })
    }

    pub fn file_kind(&self) -> FileKind {
        self.0.kind()
    }

    /// How samples become heights.
    pub fn samples(&self) -> HeightOptions {
        HeightOptions {
            scale: self.optional_number("height_scale").unwrap_or(1.0),
            offset: self.number("height_offset"),
            hole: match self.0.get("hole") {
                Some(Value::Hole(hole)) => Some(hole),
                _ => None,
            },
            raw: self
                .optional_count("columns")
                .zip(self.optional_count("rows"))
                .map(|(columns, rows)| [columns as usize, rows as usize]),
        }
    }

    pub fn has_height_scale(&self) -> bool {
        self.optional_number("height_scale").is_some()
    }

    /// Name of the image of holes, beside the source.
    pub fn hole_image(&self) -> Option<Arc<str>> {
        match self.0.get("hole_image") {
            Some(Value::Name(name)) => Some(name),
            _ => None,
        }
    }

    /// The grid of these heights. Fails if the distance of the samples is not known.
    pub fn layout(&self, heights: &Heights) -> Result<Layout, &'static str> {
        let pair = |key: &str| match self.0.get(key) {
            Some(Value::Pair(pair)) => Some(pair),
            _ => None,
        };
        let Heights { columns, rows, .. } = *heights;
        let spacing = pair("spacing")
            .or(heights.spacing)
            .ok_or("the file states no distance of its samples; name it with --set spacing=X")?;
        let [dx, dy] = spacing;
        // The middle of the grid is at the origin.
        let middle = [(columns, dx), (rows, dy)].map(|(count, own)| -0.5 * own * count.saturating_sub(1) as f64);
        let origin = pair("origin").or(heights.origin).unwrap_or(middle);
        let diagonal = if self.word("diagonal") == "falling" { Diagonal::Falling } else { Diagonal::Rising };
        Ok(Layout { columns, rows, origin, spacing, diagonal })
    }

    pub fn has_primitives(&self) -> bool {
        self.switch("primitives")
    }

    pub fn budget(&self) -> Option<&'static Budget> {
        budget(self.word("for_engine"))
    }

    pub fn within_budget(&self, vertices: u32) -> u32 {
        self.budget().map_or(vertices, |budget| vertices.min(budget.sure_vertices()))
    }

    /// How far the hull of points with this diagonal is simplified; `None` if it is not. The parts
    /// of a cover are as simple as its limits allow.
    pub fn simplify(&self, diagonal: f64) -> Option<Limit> {
        match (self.switch("decompose"), self.optional_count("max_vertices"), self.max_error()) {
            (true, ..) => None,
            (_, Some(count), _) => Some(Limit::Vertices(count as usize)),
            (_, _, Some(error)) => Some(Limit::Distance(error.resolve(diagonal))),
            _ => None,
        }
    }

    fn max_error(&self) -> Option<Length> {
        self.length("max_error")
    }

    fn length(&self, key: &str) -> Option<Length> {
        match self.0.get(key) {
            Some(Value::Number(error)) => Some(Length::Absolute(error)),
            Some(Value::Percent(percent)) => Some(Length::Relative(percent / 100.0)),
            _ => None,
        }
    }

    fn optional_number(&self, key: &str) -> Option<f64> {
        match self.0.get(key) {
            Some(Value::Number(number)) => Some(number),
            _ => None,
        }
    }

    fn optional_count(&self, key: &str) -> Option<u32> {
        match self.0.get(key) {
            Some(Value::Count(count)) => Some(count),
            _ => None,
        }
    }

    /// Whether the pack's name keeps the mesh's extension; `None`: the other names decide.
    pub fn keeps_extension(&self) -> Option<bool> {
        match self.word("pack_names") {
            "stem" => Some(false),
            "full" => Some(true),
            _ => None,
        }
    }

    pub fn record_source(&self) -> RecordSource {
        match self.word("record_source") {
            "name" => RecordSource::Name,
            "none" => RecordSource::None,
            _ => RecordSource::Relative,
        }
    }

    pub fn is_lean(&self) -> bool {
        self.switch("lean")
    }

    pub fn format_version(&self) -> u32 {
        match self.file_kind() {
            FileKind::Pack => version::Layout { is_lean: self.is_lean(), is_extended: true }.version(),
            FileKind::TriangleMesh => triangle_mesh::FORMAT_VERSION,
            FileKind::HeightField => height_field::FORMAT_VERSION,
        }
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
    use crate::options::layer::tests::VALUES;

    pub fn options(pairs: &[(&str, &str)]) -> BuildOptions {
        crate::options::layer::tests::layer(pairs).resolve()
    }

    #[test]
    fn defaults_are_those_of_the_libraries() {
        let usual = BuildOptions::default();
        assert_eq!(usual.import(), ImportOptions::DEFAULT);
        assert_eq!(usual.index(), IndexKind::default());
        assert_eq!((usual.decompose(), usual.simplify(1.0)), (None, None));
        let cover = Some(Cover::default());
        assert_eq!(options(&[("decompose", "true")]).decompose(), cover);
    }

    #[test]
    fn helps_state_the_defaults_of_parts() {
        let Length::Relative(share) = Cover::default().max_error else {
            panic!("the default is a share of the diagonal");
        };
        for (key, default) in
            [("max_vertices", PART_VERTICES.to_string()), ("max_error", format!("{}%", 100.0 * share))]
        {
            let help = OPTIONS[position(key).unwrap()].help;
            assert!(help.contains(&format!("parts: {default})")), "{key}: {help}");
        }
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
            assert_eq!(options(&[("index", kind.as_str())]).index(), kind);
        }
        assert_eq!(options(&[("max_vertices", "64")]).simplify(3.0), Some(Limit::Vertices(64)));
        assert_eq!(options(&[("max_error", "1e-3")]).simplify(3.0), Some(Limit::Distance(1e-3)));
        let names = ["auto", "stem", "full"].map(|names| options(&[("pack_names", names)]).keeps_extension());
        assert_eq!(names, [None, Some(false), Some(true)]);
        assert_eq!(options(&[("max_error", "1%")]).simplify(3.0), Some(Limit::Distance(0.03)));
        assert!(options(&[("lean", "true")]).is_lean() && !BuildOptions::default().is_lean());
        let cover = |key, value| options(&[("decompose", "true"), (key, value)]).decompose();
        let usual = Cover::default();
        assert_eq!(cover("max_error", "0.5"), Some(Cover { max_error: Length::Absolute(0.5), ..usual }));
        assert_eq!(cover("max_error", "1%"), Some(Cover { max_error: Length::Relative(0.01), ..usual }));
        assert_eq!(cover("max_vertices", "32"), Some(Cover { max_vertices: Some(32), ..usual }));
        assert_eq!(cover("max_parts", "7"), Some(Cover { max_parts: Some(7), ..usual }));
        assert_eq!(cover("solid", "walls"), Some(Cover { solid: SolidRule::Walls, ..usual }));
        assert_eq!(cover("solid", "closed"), Some(Cover { solid: SolidRule::Closed, ..usual }));
        assert_eq!(cover("wall", "1%"), Some(Cover { wall: Length::Relative(0.01), ..usual }));
        assert_eq!(cover("wall", "0.5"), Some(Cover { wall: Length::Absolute(0.5), ..usual }));
        assert!(options(&[("decompose", "true"), ("primitives", "true")]).has_primitives());
        assert_eq!(cover("decompose_seconds", "1.5"), Some(Cover { seconds: Some(1.5), ..usual }));
        assert_eq!(options(&[("decompose", "true"), ("max_vertices", "32")]).simplify(1.0), None);
        let kinds = ["false", "true"].map(|value| options(&[("keep_triangles", value)]).file_kind());
        assert_eq!(kinds, [FileKind::Pack, FileKind::TriangleMesh]);
        let terrain = options(&VALUES);
        let samples =
            HeightOptions { scale: -0.1, offset: -1e-300, hole: "-3.402823e+38".parse().ok(), raw: Some([4096, 17]) };
        assert_eq!((terrain.samples(), terrain.hole_image().as_deref()), (samples, Some("holes of a x.png")));
        let heights = |spacing, origin| Heights {
            columns: 3,
            rows: 5,
            heights: Vec::new(),
            hole_samples: 0,
            origin,
            spacing,
            is_image: false,
        };
        let expected =
            Layout { columns: 3, rows: 5, origin: [-5.25, 7e5], spacing: [2.0, 3.0], diagonal: Diagonal::Falling };
        assert_eq!(terrain.layout(&heights(Some([9.0; 2]), Some([9.0; 2]))), Ok(expected));
        let plain = options(&[("terrain", "true")]);
        let layout = plain.layout(&heights(Some([4.0; 2]), None)).unwrap();
        assert_eq!((layout.origin, layout.diagonal), ([-4.0, -8.0], Diagonal::Rising), "centred");
        assert!(plain.layout(&heights(None, None)).unwrap_err().contains("--set spacing"));
    }

    /// A level below a folder whose meshes are decomposed keeps its triangles.
    #[test]
    fn options_of_hulls_do_not_apply_to_triangles() {
        let values: Vec<_> = VALUES.into_iter().filter(|(key, _)| *key != "terrain").collect();
        let level = options(&values);
        assert_eq!(level.file_kind(), FileKind::TriangleMesh);
        // A terrain in a folder whose levels keep their triangles has their options neither.
        let terrain = options(&VALUES);
        let text = "split none, vertices referenced, index none, terrain true, spacing 2,3, height_scale -0.1";
        assert!(terrain.to_string().starts_with(text), "{terrain}");
        assert_eq!((level.decompose(), level.simplify(1.0), level.budget().is_some()), (None, None, false));
        let import = level.import();
        assert_eq!((import.split, import.recentre), (Split::None, false));
        assert_eq!((import.unit_scale, import.up_axis), (0.01, UpAxis::YToZ));
    }
}
