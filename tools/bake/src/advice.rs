//! What a user should look at: hulls that bake, but may not be what was meant.
//!
//! `bake build` and `bake report` say it, in the same words.
//!
//! Every threshold is a ratio: nothing changes where a mesh is scaled, but for the one limit that f32 itself has.

/// Size of a hull in widths of it beyond which it is thin: of the seven digits of f32, three are left across it.
const THIN: f64 = 1e4;

/// Vertices beyond which a hull is huge: it takes 13 MB in a pack, more than the processor's nearer caches, and every
/// query of it waits for memory.
const HUGE_VERTICES: usize = 1 << 16;

/// Coordinate beyond which a hull is huge: its square no longer fits f32, and engines that measure distances in f32
/// get infinities. The one threshold with a unit, that of the source.
const HUGE_COORDINATE: f64 = 1.8e19;

/// Share of the size by which a hull, or the parts of a mesh, may leave their source before it is a warning: contacts that are
/// a hundredth early or late are seen.
const LOOSE: f64 = 0.01;

/// A sentence for one of two lists.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Remark {
    /// What the user may want to know.
    Note(String),
    /// What the user should look at, with the remedy.
    Warning(String),
}

impl Remark {
    /// The text as a note, or with a remedy as a warning where `error` is loose for `size`.
    fn by_size(text: String, error: f64, size: f64, remedy: &str) -> Self {
        // NaN is a warning.
        if error <= LOOSE * size { Self::Note(text) } else { Self::Warning(format!("{text}; {remedy}")) }
    }

    /// Adds it to the list that it is for.
    pub fn tell(self, notes: &mut Vec<String>, warnings: &mut Vec<String>) {
        match self {
            Self::Note(text) => notes.push(text),
            Self::Warning(text) => warnings.push(text),
        }
    }
}

/// What is known of a baked hull.
#[derive(Clone, Copy, Debug)]
pub struct HullFacts<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its dimension: 3 solid, 2 polygon, 1 segment, 0 point.
    pub rank: u32,
    /// Points that it was built of.
    pub point_count: usize,
    /// Vertices that it has.
    pub vertex_count: usize,
    /// Greatest distance between two vertices.
    pub diameter: f64,
    /// Radius of a ball in it, around its centroid.
    pub inner_radius: f64,
    /// Greatest absolute value of its coordinates.
    pub greatest_coordinate: f64,
    /// How far it may reach beyond its source; 0 for an exact one.
    pub outer_error: f64,
}

/// What a simplified hull promises; `None` for one that is exact.
pub fn simplified(facts: &HullFacts) -> Option<Remark> {
    let HullFacts { name, vertex_count, outer_error, diameter, .. } = *facts;
    if outer_error == 0.0 {
        return None;
    }
    let share = outer_error / diameter;
    let text = format!(
        "hull {name}: {vertex_count} vertices, outside the source by {outer_error:.3e} at most ({share:.1e} of the diameter)"
    );
    let remedy = "a greater --max-vertices, or a lesser --max-error, brings it nearer";
    Some(Remark::by_size(text, outer_error, diameter, remedy))
}

/// What the `count` parts of a set promise; `size` is that of the greatest part.
pub fn parts(name: &str, count: usize, uncovered: f64, size: f64) -> Remark {
    let text = format!("{name}: {count} parts; every vertex is in one, or {uncovered:.3e} away at most");
    Remark::by_size(text, uncovered, size, "a greater --vhacd-resolution or --vhacd-max-parts leaves out less")
}

/// Warns of what is flat, thin or huge.
pub fn of_hull(facts: &HullFacts) -> Vec<String> {
    let name = facts.name;
    let mut warnings = Vec::new();
    match facts.rank {
        3 => {
            // The ball around the centroid is the widest but for a factor of three: a centroid lies at least a quarter
            // of the width away from each side.
            let width = 2.0 * facts.inner_radius;
            if !(facts.diameter <= THIN * width) {
                warnings.push(format!(
                    "hull {name} is thin: {:.3e} across and about {width:.1e} thick; contacts on it are poor in digits: thicken it, or leave it out if it is a decal",
                    facts.diameter
                ));
            }
        }
        // A single source point, and a line of two, are as flat as they were meant.
        2 => warnings.push(format!(
            "hull {name} is flat: its {} points lie in one plane; it collides as a polygon without thickness: give it thickness if it should be a solid",
            facts.point_count
        )),
        1 if facts.point_count > 2 => warnings.push(format!(
            "hull {name} is a segment: its {} points lie on one line; is an axis scaled to 0?",
            facts.point_count
        )),
        0 if facts.point_count > 1 => warnings.push(format!(
            "hull {name} is a point: its {} points are all the same; is the object scaled to 0?",
            facts.point_count
        )),
        _ => {}
    }
    if facts.vertex_count > HUGE_VERTICES {
        warnings.push(format!(
            "hull {name} is huge: {} vertices, more than {HUGE_VERTICES}; --max-vertices or --max-error make it smaller within a stated distance",
            facts.vertex_count
        ));
    }
    if facts.greatest_coordinate > HUGE_COORDINATE {
        warnings.push(format!(
            "hull {name} reaches {:.1e} from the origin, and squares of that overflow 32-bit floats; use a smaller --unit-scale",
            facts.greatest_coordinate
        ));
    }
    warnings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_trouble_has_its_words() {
        let plain = HullFacts {
            name: "a",
            rank: 3,
            point_count: 100,
            vertex_count: 80,
            diameter: 1.0,
            inner_radius: 0.3,
            greatest_coordinate: 1.0,
            outer_error: 0.0,
        };
        let words = |facts| of_hull(&facts).join("; ");
        assert_eq!(words(plain), "");
        assert_eq!(words(HullFacts { inner_radius: 1e-4, ..plain }), "");
        assert!(words(HullFacts { inner_radius: 4e-5, ..plain }).contains("hull a is thin"));
        assert!(words(HullFacts { inner_radius: f64::NAN, ..plain }).contains("thin"));
        assert!(words(HullFacts { rank: 2, ..plain }).contains("flat"));
        assert!(words(HullFacts { rank: 1, ..plain }).contains("segment"));
        assert!(words(HullFacts { rank: 0, ..plain }).contains("is a point"));
        assert_eq!(words(HullFacts { rank: 1, point_count: 2, ..plain }), "");
        assert_eq!(words(HullFacts { rank: 0, point_count: 1, ..plain }), "");
        assert!(words(HullFacts { vertex_count: 65_537, ..plain }).contains("--max-vertices"));
        assert!(words(HullFacts { greatest_coordinate: 1e20, ..plain }).contains("overflow"));
    }

    #[test]
    fn what_is_not_exact_is_noted_and_what_is_loose_is_warned_of() {
        let said = |remark: Remark| {
            let (mut notes, mut warnings) = (Vec::new(), Vec::new());
            remark.tell(&mut notes, &mut warnings);
            (notes.join("; "), warnings.join("; "))
        };
        let simple = |outer_error| {
            simplified(&HullFacts {
                name: "a",
                rank: 3,
                point_count: 9,
                vertex_count: 8,
                diameter: 10.0,
                inner_radius: 1.0,
                greatest_coordinate: 1.0,
                outer_error,
            })
        };
        assert_eq!(simple(0.0), None);
        let (note, warning) = said(simple(0.05).unwrap());
        assert!(note.contains("hull a: 8 vertices, outside the source by 5.000e-2 at most") && warning.is_empty());
        let (note, warning) = said(simple(0.2).unwrap());
        assert!(note.is_empty() && warning.contains("2.0e-2 of the diameter); a greater --max-vertices"), "{warning}");
        assert!(matches!(simple(f64::NAN), Some(Remark::Warning(_))));
        assert!(matches!(parts("a", 3, 1e-3, 1.0), Remark::Note(_)));
        let (_, warning) = said(parts("a", 3, 0.02, 1.0));
        assert!(warning.contains("a: 3 parts;") && warning.contains("--vhacd-resolution"), "{warning}");
    }
}
