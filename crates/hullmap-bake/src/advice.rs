//! Warnings and notes about hulls that bake, but may not be what the user meant.
//!
//! All thresholds are ratios, so that scaling a mesh changes nothing, except for the range of f32.

use std::collections::HashMap;

use crate::decompose::Cover;
use crate::fit::{self, Looseness, SolidRule};
use crate::{baked_hull::BakedHull, fit::Fit, mass};
use hullmap_format::SolidKind;
use hullmap_geometry::PointSet;
use hullmap_geometry::number::{grouped, percent, rounded, short};

pub mod usability;

/// Diameter over width above which a hull is thin: f32 leaves three of its seven digits across it.
const THIN: f64 = 1e4;

/// A pack with more vertices takes over 13 MB, more than the processor's inner caches hold.
const HUGE_VERTICES: usize = 1 << 16;

/// Coordinate above which a hull is huge: its square overflows f32, and engines that measure
/// distances in f32 get infinities. This is the only threshold with a unit: the unit of the source.
const HUGE_COORDINATE: f64 = 1.8e19;

/// Relative error above which an inexact hull is a warning: the errors of contacts are visible.
const LOOSE: f64 = 0.01;

const MAX_NAMES: usize = 8;

/// A sentence for the user about one hull or object.
#[derive(Clone, Debug, PartialEq)]
pub struct Remark {
    /// True for a finding to act on, with its remedy; false for information.
    pub is_warning: bool,
    /// Remarks of one topic become one sentence.
    topic: String,
    name: String,
    text: String,
    /// Among remarks on one topic, the one with the largest weight is shown in full.
    weight: f64,
}

/// Excess of a hull's volume over its mesh's from which the mesh is worth decomposing. Hulls of
/// meshes with bevels and screw heads stay below.
const HOLLOW: f64 = 0.1;

/// Warnings and notes about baked hulls, simplified hulls first. `is_cut` returns, for the index of
/// a hull, whether the bake made the hull as a part of a mesh.
pub fn of_hulls(hulls: &[BakedHull], is_cut: impl Fn(usize) -> bool) -> Vec<Remark> {
    let of = |(index, baked)| HullMeasures { is_cut: is_cut(index), ..HullMeasures::from_baked(baked) };
    let measures = || hulls.iter().enumerate().map(of);
    let hollows = hulls.iter().filter_map(|hull| Some(concave(&hull.name, excess_of_baked(hull)?)));
    let about_shapes = measures().filter_map(|hull| simplified(&hull)).chain(hollows);
    about_shapes.chain(measures().flat_map(|hull| of_hull(&hull))).collect()
}

impl Remark {
    /// A finding of interest.
    pub fn note(topic: impl Into<String>, name: &str, text: String) -> Self {
        Self { is_warning: false, topic: topic.into(), name: name.to_owned(), text, weight: 0.0 }
    }

    /// A finding to act on.
    pub fn warning(topic: impl Into<String>, name: &str, text: String) -> Self {
        Self { is_warning: true, ..Self::note(topic, name, text) }
    }

    /// The sentence.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// A note if `error` is small relative to `size`, otherwise a warning with the remedy.
    fn by_size(topic: &str, name: &str, text: String, error: f64, size: f64, remedy: &str) -> Self {
        // NaN is a warning.
        let remark = if error <= LOOSE * size {
            Self::note(topic, name, text)
        } else {
            Self::warning(topic, name, format!("{text}; {remedy}"))
        };
        Self { weight: error / size, ..remark }
    }
}

/// Notes and warnings, one for each topic of the remarks, in the order in which the topics appear.
/// So hundreds of parts with the same problem produce one warning.
pub fn summarise(remarks: impl IntoIterator<Item = Remark>) -> (Vec<String>, Vec<String>) {
    let mut topics: Vec<Vec<Remark>> = Vec::new();
    let mut positions: HashMap<(bool, String), usize> = HashMap::new();
    for remark in remarks {
        let position = *positions.entry((remark.is_warning, remark.topic.clone())).or_insert(topics.len());
        if position == topics.len() {
            topics.push(Vec::new());
        }
        topics[position].push(remark);
    }
    let (mut notes, mut warnings) = (Vec::new(), Vec::new());
    for topic in topics {
        let mut worst = 0;
        for (index, remark) in topic.iter().enumerate() {
            if remark.weight.total_cmp(&topic[worst].weight).is_gt() {
                worst = index;
            }
        }
        let others = (0..topic.len()).filter(|&index| index != worst).map(|index| topic[index].name.as_str());
        let mut text = topic[worst].text.clone();
        if topic.len() > 1 {
            let count = topic.len() - 1;
            let names: Vec<&str> = others.take(MAX_NAMES).collect();
            let more = if count > MAX_NAMES { ", …" } else { "" };
            text += &format!(" (and {count} more like it: {}{more})", names.join(", "));
        }
        if topic[worst].is_warning { warnings.push(text) } else { notes.push(text) }
    }
    (notes, warnings)
}

/// The measures of a baked hull that warnings depend on.
#[derive(Clone, Copy, Debug)]
pub struct HullMeasures<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its dimension: 3 solid, 2 polygon, 1 segment, 0 point.
    pub rank: u32,
    /// Number of points it was built from.
    pub point_count: usize,
    /// Number of vertices.
    pub vertex_count: usize,
    /// Maximum distance between two vertices.
    pub diameter: f64,
    /// Radius of a ball inside it, around its centroid.
    pub inner_radius: f64,
    /// Maximum absolute value of its coordinates.
    pub max_coordinate: f64,
    /// Bound on how far it extends beyond its source; 0 for an exact hull.
    pub outer_error: f64,
    /// Whether it is a part into which a mesh was cut. Its thickness is then not the mesh's:
    /// [`usability`] judges it.
    pub is_cut: bool,
}

impl<'a> HullMeasures<'a> {
    /// The measures of a baked hull.
    pub fn from_baked(baked: &'a BakedHull) -> Self {
        let coordinates = baked.hull.vertices.iter().flatten();
        Self {
            name: &baked.name,
            rank: baked.hull.rank,
            point_count: baked.point_count,
            vertex_count: baked.hull.vertices.len(),
            diameter: baked.hull.diameter,
            inner_radius: baked.interior.inner_radius,
            max_coordinate: coordinates.map(|x| f64::from(x.abs())).fold(0.0, f64::max),
            outer_error: baked.outer_error,
            is_cut: false,
        }
    }
}

/// Outer error of a simplified hull; `None` for an exact hull.
pub fn simplified(facts: &HullMeasures) -> Option<Remark> {
    let HullMeasures { name, vertex_count, outer_error, diameter, .. } = *facts;
    if outer_error == 0.0 {
        return None;
    }
    let (length, share) = (short(outer_error), percent(outer_error / diameter));
    let text = format!(
        "hull {name}: simplified to {vertex_count} vertices; extends at most {length} beyond the source \
         ({share} of the diameter)"
    );
    let remedy = "for a closer fit, increase --max-vertices or decrease --max-error";
    Some(Remark::by_size("simplified", name, text, outer_error, diameter, remedy))
}

/// Excess of a hull's volume over its mesh's, relative to the latter; `None` if the mesh is not
/// worth decomposing.
pub fn excess(hull_volume: f64, mesh_volume: f64) -> Option<f64> {
    let excess = hull_volume / mesh_volume - 1.0;
    // Written so that NaN is no remark.
    (excess > HOLLOW).then_some(excess)
}

/// `None` for a part, and for a mesh without a known volume.
fn excess_of_baked(baked: &BakedHull) -> Option<f64> {
    let mesh = baked.mesh_mass.as_ref().filter(|_| baked.fit.is_none() && baked.hull.rank == 3)?;
    excess(mass::mass(&baked.hull).volume, mesh.volume)
}

/// Note on the hull of a whole mesh that fills its cavities, by its [`excess`].
pub fn concave(name: &str, excess: f64) -> Remark {
    let share = percent(excess);
    let text = format!(
        "{name}: the mesh is concave, and its hull has {share} more volume; for convex parts that follow the mesh, \
         use --decompose"
    );
    Remark { weight: excess, ..Remark::note("concave", name, text) }
}

/// How the parts of an object fit its mesh, as proven bounds; lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartsFit {
    /// Kind of the mesh's solid.
    pub solid: SolidKind,
    /// Bound on how far a point of the surface lies outside all parts.
    pub uncovered: f64,
    /// Bound on how far a point of a part lies outside the solid.
    pub protrusion: f64,
}

impl PartsFit {
    /// The fit of all parts of one object together.
    ///
    /// # Panics
    /// If there are no parts.
    pub fn from_fits(parts: &[Fit]) -> Self {
        let protrusion = parts.iter().map(|part| part.protrusion).fold(0.0, f64::max);
        Self { solid: parts[0].solid, uncovered: parts[0].uncovered, protrusion }
    }
}

/// How the parts of an object fit together, in words: how far they protrude on average, how much
/// they overlap, which share of the solid is in none of them, and the equation of their plane of
/// symmetry, if these are known. All but the last are estimates.
pub fn estimates(found: &Looseness, voids: Option<f64>, symmetry: Option<&str>) -> String {
    let Looseness { overlap, overlap_error, mean_protrusion, .. } = *found;
    let overlap = if overlap <= overlap_error {
        format!("less than {}", percent(overlap + overlap_error))
    } else {
        percent(overlap)
    };
    let mut words = vec![format!("protrude by {} on average", short(mean_protrusion)), format!("overlap by {overlap}")];
    words.extend(voids.map(|share| {
        if share == 0.0 { "fill the solid".to_owned() } else { format!("leave {} of the solid empty", percent(share)) }
    }));
    words.extend(symmetry.map(|plane| format!("are symmetric about {plane}")));
    let last = words.pop().unwrap_or_default();
    format!("the parts {}{} {last}", words.join(", "), if words.len() > 1 { ", and" } else { " and" })
}

/// Share of the solid in no part, above which there is a warning.
const EMPTY: f64 = 0.01;

/// Warning about parts that leave the share `voids` of the solid empty; `None` if it is small.
pub fn empty(name: &str, voids: f64) -> Option<Remark> {
    // Written so that NaN is no remark.
    (voids > EMPTY).then(|| {
        let text = format!(
            "{name}: {} of the solid is in no part, so bodies that start there are not pushed out; try \
             another --max-error",
            percent(voids)
        );
        Remark { weight: voids, ..Remark::warning("empty", name, text) }
    })
}

/// Bulge, relative to the diagonal, above which there is a note: a body of 1 m that rests on that
/// part floats 1 cm above the visible surface.
const BULGE: f64 = 0.01;

/// Note on parts that extend beyond their mesh's convex hull by at most the length `outside`;
/// `None` if it is short. A limit on vertices makes the planes on that side round it off.
pub fn bulge(name: &str, outside: f64, diagonal: f64, cover: &Cover) -> Option<Remark> {
    let share = outside / diagonal;
    // Written so that NaN is no remark.
    (share > BULGE).then(|| {
        let text = format!(
            "{name}: parts extend up to {} ({} of the diagonal) beyond the convex hull of the mesh, because {} vertices \
             cannot follow its round faces; for bodies that rest on them, increase --max-vertices",
            short(outside),
            percent(share),
            cover.part_vertices(),
        );
        Remark { weight: share, ..Remark::note("beyond the hull", name, text) }
    })
}

/// Note on a mesh that only the maximum number of vertices divides: one part of `vertices` is
/// within the maximum error.
pub fn divided_by_vertices(name: &str, vertices: usize, cover: &Cover) -> Remark {
    let text = format!(
        "{name}: {} vertices a part do not suffice for the error; one part of {vertices} would do: add --max-vertices \
         {vertices}",
        cover.part_vertices(),
    );
    Remark::note("divided by vertices", name, text)
}

/// Note on the number of parts that primitives may replace; `is_late` if the deadline ended the
/// search.
pub fn primitives(name: &str, count: usize, of: usize, is_late: bool) -> Remark {
    let noun = if of == 1 { "part" } else { "parts" };
    let late = if is_late { "; --set decompose_seconds ended the search for more" } else { "" };
    let text =
        format!("{name}: {count} of {of} {noun} can be replaced by a box, sphere, capsule or cylinder, proven{late}");
    Remark::note("primitives", name, text)
}

/// Uncovered distance, relative to the size, that counts as covered: the containment error that a
/// hull may have, 1e-7, with room for rounding.
const COVERED: f64 = 1.5e-7;

/// How the `count` parts of an object fit it, if that was measured; `size` is the diameter of the
/// largest part. `estimates` are words of [`estimates`].
pub fn parts(name: &str, count: usize, fit: Option<PartsFit>, size: f64, estimates: Option<&str>) -> Remark {
    let noun = if count == 1 { "part" } else { "parts" };
    let Some(PartsFit { solid, uncovered, protrusion }) = fit else {
        let text = format!("{name}: {count} {noun}; not measured, because a bound is not finite");
        return Remark::note("unmeasured parts", name, text);
    };
    let covered = if uncovered <= COVERED * size {
        "the whole surface is covered".to_owned()
    } else {
        format!("the surface lies at most {} outside all parts", short(uncovered))
    };
    let (from, how) = match solid {
        SolidKind::Watertight => ("the solid", ""),
        SolidKind::Closed => ("the solid", "; the mesh's holes were closed first"),
        SolidKind::Walls => ("the walls", "; the mesh is open or encloses nothing, so its walls are its solid"),
    };
    let protrusion = short(protrusion);
    let more = estimates.map_or_else(String::new, |words| format!("; {words}"));
    let text = format!(
        "{name}: {count} {noun}; {covered}, and no part protrudes more than {protrusion} from {from}{how}{more}"
    );
    Remark::by_size("parts", name, text, uncovered, size, "to cover more, decompose the mesh with --decompose")
}

/// Number of parts above which walls may not be meant.
const MANY_WALLS: usize = 64;

/// Warning about a mesh whose walls became many parts, without a request for walls.
pub fn many_walls(name: &str, count: usize, fit: Option<PartsFit>, cover: &Cover) -> Option<Remark> {
    let is_walls = fit.is_some_and(|fit| fit.solid == SolidKind::Walls) && cover.solid == SolidRule::Auto;
    (is_walls && count > MANY_WALLS).then(|| {
        let text = format!(
            "{name}: the mesh is open, and its walls became {count} parts; if it is solid, add --solid closed, otherwise \
             increase --max-error"
        );
        Remark { weight: count as f64, ..Remark::warning("many walls", name, text) }
    })
}

/// Area of closed holes, relative to the mesh's, above which they may be intended openings.
const OPENING: f64 = 0.05;

/// Warning about a mesh whose large holes were closed, which made their inside solid. `share` is
/// the holes' area relative to the mesh's.
pub fn openings(name: &str, share: f64) -> Option<Remark> {
    // NaN takes the failing branch.
    (share >= OPENING).then(|| {
        let text = format!(
            "{name}: its holes were closed by triangles with {} of its area, and what they enclose counts as solid; to \
             keep openings such as the mouth of a pot, with more parts, add --solid walls",
            percent(share)
        );
        Remark { weight: share, ..Remark::warning("closed openings", name, text) }
    })
}

/// Words of the warning about reversed triangles, and of no other.
pub const REVERSED: &str = "the other way than the triangles beside";

/// Warning about a closed mesh without a known mass, because some triangles are reversed.
pub fn reversed(mesh: &PointSet) -> Option<Remark> {
    let (reversed, is_closed) = fit::reversed(mesh);
    let (name, first) = (&mesh.name, *reversed.first().filter(|_| is_closed)?);
    let corners = mesh.triangles[first].map(|v| mesh.positions[v as usize].map(f64::from));
    let at = [0, 1, 2].map(|axis| rounded(corners.iter().map(|corner| corner[axis]).sum::<f64>() / 3.0)).join(" ");
    let found = match reversed.len() {
        1 => format!("triangle {first} (at {at}) is reversed: it faces"),
        count => format!("{} triangles are reversed, the first is {first} (at {at}): they face", grouped(count as u64)),
    };
    let text = format!(
        "{name}: {found} {REVERSED}, so the mass of the mesh is not recorded; recalculate the normals in an editor"
    );
    Some(Remark { weight: reversed.len() as f64, ..Remark::warning("reversed triangles", name, text) })
}

/// A mesh that cannot be decomposed, because it has no surface.
pub fn without_faces(name: &str) -> Remark {
    let text = format!("{name}: not decomposed, because it has no faces; add faces");
    Remark::warning("no faces", name, text)
}

/// Protrusion, relative to the diagonal, that an engine cannot use even if the number of parts was
/// requested: of a body of 1 m, another one rests 5 cm above what is seen.
pub const FAR: f64 = 0.05;

/// Parts that protrude more than requested: by the length `reached`, instead of `requested`; `size`
/// is the mesh's diagonal. With a maximum number of parts this is a note up to [`FAR`], since the
/// error is an output, not a limit; a search that ended early is a warning.
pub fn beyond(name: &str, max_parts: Option<u32>, is_timed: bool, [reached, requested, size]: [f64; 3]) -> Remark {
    let share = percent(reached / size);
    let shares = format!("{} ({share} of the diagonal) instead of {}", short(reached), short(requested));
    match max_parts {
        Some(count) => {
            let until = if is_timed { "in the time of --set decompose_seconds" } else { "by the search" };
            let noun = if count == 1 { "part" } else { "parts" };
            let text = format!("{name}: with at most {count} {noun}, the smallest error reached {until} is {shares}");
            if reached > FAR * size {
                let text = format!("{text}, so bodies collide where nothing is; increase --max-parts");
                Remark::warning("error of parts", name, text)
            } else {
                let text = format!("{text}; to lower it, increase --max-parts or --max-vertices");
                Remark::note("error of parts", name, text)
            }
        }
        None => {
            let remedy = if is_timed {
                "the search ended by --set decompose_seconds; increase it"
            } else {
                "the search did not prove less; increase --max-error or --max-vertices"
            };
            Remark::warning("excess of parts", name, format!("{name}: parts protrude by {shares}: {remedy}"))
        }
    }
}

/// Warnings about flat, thin and huge hulls.
pub fn of_hull(facts: &HullMeasures) -> Vec<Remark> {
    let name = facts.name;
    let mut warnings = Vec::new();
    let mut warn = |topic: &str, text: String| warnings.push(Remark::warning(topic, name, text));
    match facts.rank {
        _ if facts.is_cut => {}
        3 => {
            // The ball around the centroid has at least half the radius of the largest one: a
            // centroid is at least a quarter of the width away from each side.
            let width = 2.0 * facts.inner_radius;
            if !(facts.diameter <= THIN * width) {
                warn(
                    "thin",
                    format!(
                        "hull {name} is thin: {} long and about {} thick, so contacts on it are imprecise; thicken it, \
                     or leave it out if it is a decal",
                        short(facts.diameter),
                        short(width)
                    ),
                );
            }
        }
        // A single source point, or a line between two, is meant to be flat.
        2 => warn(
            "flat",
            format!(
                "hull {name} is flat: its {} points lie in one plane, and it collides as a polygon without thickness; \
             thicken it if it should be a solid",
                facts.point_count
            ),
        ),
        1 if facts.point_count > 2 => warn(
            "segment",
            format!(
                "hull {name} is a segment: its {} points lie on one line; check whether an axis is scaled to 0",
                facts.point_count
            ),
        ),
        0 if facts.point_count > 1 => warn(
            "point",
            format!(
                "hull {name} is a point: its {} points coincide; check whether the object is scaled to 0",
                facts.point_count
            ),
        ),
        _ => {}
    }
    if facts.vertex_count > HUGE_VERTICES {
        warn(
            "huge",
            format!(
                "hull {name} is huge: it has {} vertices, more than {HUGE_VERTICES}; simplify it with --max-vertices or --max-error",
                facts.vertex_count
            ),
        );
    }
    if facts.max_coordinate > HUGE_COORDINATE {
        warn(
            "overflow",
            format!(
                "hull {name} extends {} from the origin, and the square of that overflows 32-bit floats; use a smaller --unit-scale",
                short(facts.max_coordinate)
            ),
        );
    }
    warnings
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAIN: HullMeasures = HullMeasures {
        name: "a",
        rank: 3,
        point_count: 100,
        vertex_count: 80,
        diameter: 1.0,
        inner_radius: 0.3,
        max_coordinate: 1.0,
        outer_error: 0.0,
        is_cut: false,
    };

    #[test]
    fn each_problem_has_its_warning() {
        for facts in [
            PLAIN,
            HullMeasures { inner_radius: 1e-4, ..PLAIN },
            HullMeasures { inner_radius: 4e-5, is_cut: true, ..PLAIN },
            HullMeasures { rank: 1, point_count: 2, ..PLAIN },
            HullMeasures { rank: 0, point_count: 1, ..PLAIN },
        ] {
            assert_eq!(of_hull(&facts), [], "{facts:?}");
        }
        for (expected, facts) in [
            ("hull a is thin", HullMeasures { inner_radius: 4e-5, ..PLAIN }),
            ("thin", HullMeasures { inner_radius: f64::NAN, ..PLAIN }),
            ("flat", HullMeasures { rank: 2, ..PLAIN }),
            ("segment", HullMeasures { rank: 1, ..PLAIN }),
            ("is a point", HullMeasures { rank: 0, ..PLAIN }),
            ("--max-vertices", HullMeasures { vertex_count: 65_537, ..PLAIN }),
            ("overflow", HullMeasures { max_coordinate: 1e20, ..PLAIN }),
        ] {
            let words = summarise(of_hull(&facts)).1.join("; ");
            assert!(words.contains(expected), "{expected}: {words}");
        }
    }

    #[test]
    fn small_errors_are_notes_and_large_ones_warnings() {
        let texts = |remark: Remark| {
            let (notes, warnings) = summarise([remark]);
            (notes.join("; "), warnings.join("; "))
        };
        let simple = |outer_error| simplified(&HullMeasures { vertex_count: 8, diameter: 10.0, outer_error, ..PLAIN });
        assert_eq!(simple(0.0), None);
        let (note, warning) = texts(simple(0.05).unwrap());
        assert!(
            note.contains(
                "hull a: simplified to 8 vertices; extends at most 0.05 beyond the source (0.5% of the diameter)"
            ) && warning.is_empty()
        );
        let (note, warning) = texts(simple(0.2).unwrap());
        assert!(
            note.is_empty() && warning.contains("2% of the diameter); for a closer fit, increase --max-vertices"),
            "{warning}"
        );
        assert!(simple(f64::NAN).unwrap().is_warning);
        let fit = |uncovered| Some(PartsFit { solid: SolidKind::Watertight, uncovered, protrusion: 0.25 });
        assert!(!parts("a", 3, fit(1e-3), 1.0, None).is_warning);
        let covered = "a: 3 parts; the whole surface is covered, and no part protrudes more than 0.25 from the solid";
        assert_eq!(texts(parts("a", 3, fit(0.0), 1.0, None)).0, covered);
        assert!(texts(parts("a", 3, None, 1.0, None)).0.contains("not measured"));
        assert!(parts("a", 3, fit(f64::NAN), 1.0, None).is_warning);
        let (_, warning) = texts(parts("a", 3, fit(0.02), 1.0, None));
        assert!(warning.contains("a: 3 parts;") && warning.contains("--decompose"), "{warning}");
    }

    #[test]
    fn parts_that_protrude_too_far_are_explained() {
        let few = beyond("a", Some(3), false, [0.09, 0.04, 2.0]);
        assert!(!few.is_warning && few.text.contains("at most 3 parts") && few.text.contains("4.5%"), "{few:?}");
        let too_few = beyond("a", Some(3), false, [0.25, 0.1, 2.0]);
        assert!(too_few.is_warning && too_few.text.contains("12.5%"), "{too_few:?}");
        let late = beyond("a", None, true, [0.25, 0.1, 2.0]);
        assert!(late.is_warning && late.text.contains("--set decompose_seconds; increase it"), "{late:?}");
    }

    #[test]
    fn parts_beyond_the_hull_of_the_mesh_are_noted() {
        let cover = Cover::default();
        let note = bulge("a", 0.039, 2.0, &cover).unwrap();
        let words =
            "a: parts extend up to 0.039 (1.95% of the diagonal) beyond the convex hull of the mesh, because 64";
        assert!(!note.is_warning && note.text.starts_with(words) && note.text.contains("--max-vertices"), "{note:?}");
        assert!([0.02, 0.0, f64::NAN].into_iter().all(|outside| bulge("a", outside, 2.0, &cover).is_none()));
    }

    #[test]
    fn many_parts_of_walls_that_were_not_requested_are_a_warning() {
        let cover = Cover::default();
        let fit = |solid| Some(PartsFit { solid, uncovered: 0.0, protrusion: 0.1 });
        let walls = fit(SolidKind::Walls);
        let remark = many_walls("a", 65, walls, &cover).unwrap();
        assert!(remark.is_warning && remark.text.contains("became 65 parts; if it is solid, add --solid closed"));
        assert!(many_walls("a", 64, walls, &cover).is_none());
        assert!(many_walls("a", 65, fit(SolidKind::Closed), &cover).is_none());
        assert!(many_walls("a", 65, walls, &Cover { solid: SolidRule::Walls, ..cover }).is_none());
    }

    #[test]
    fn large_voids_are_a_warning() {
        assert!(empty("a", 0.01).is_none() && empty("a", f64::NAN).is_none());
        let remark = empty("a", 0.18).unwrap();
        assert!(remark.is_warning && remark.text.contains("18% of the solid is in no part"), "{}", remark.text);
    }

    #[test]
    fn estimates_are_words_for_people() {
        let loose = Looseness { overlap: 2e-16, overlap_error: 4e-4, mean_protrusion: 0.0049, outside_hull: 0.0 };
        let words = estimates(&loose, Some(0.0), Some("x = 0"));
        assert_eq!(
            words,
            "the parts protrude by 0.0049 on average, overlap by less than 0.04%, fill the solid, and are symmetric about x = 0"
        );
        let apart = Looseness { overlap: 0.03, ..loose };
        assert_eq!(estimates(&apart, None, None), "the parts protrude by 0.0049 on average and overlap by 3%");
        assert!(estimates(&apart, Some(0.01), None).ends_with("overlap by 3%, and leave 1% of the solid empty"));
        let note = parts("a", 2, None, 1.0, Some(&words));
        assert!(!note.is_warning);
    }

    #[test]
    fn one_sentence_per_topic() {
        let names: Vec<String> = (0..12).map(|index| format!("p{index}")).collect();
        let flat = names.iter().map(|name| Remark::warning("flat", name, format!("hull {name} is flat")));
        let fit = |uncovered| Some(PartsFit { solid: SolidKind::Walls, uncovered, protrusion: 0.25 });
        let cover =
            [("a", 0.0), ("b", 1e-3), ("c", 1e-4), ("d", 0.5)].map(|(name, gap)| parts(name, 2, fit(gap), 1.0, None));
        let (notes, warnings) = summarise(flat.chain(cover));
        assert_eq!(
            notes,
            ["b: 2 parts; the surface lies at most 0.001 outside all parts, and no part protrudes more than 0.25 \
              from the walls; the mesh is open or encloses nothing, so its walls are its solid (and 2 more like it: a, \
              c)"]
        );
        assert_eq!(warnings[0], "hull p0 is flat (and 11 more like it: p1, p2, p3, p4, p5, p6, p7, p8, …)");
        assert!(warnings.len() == 2 && warnings[1].starts_with("d: 2 parts;"), "{warnings:?}");
    }
}
