//! Whether a physics engine can use the parts of an object: their thickness, protrusion, overlap
//! and coverage.

use hullmap_format::SolidKind;

use super::{COVERED, FAR, Remark, beyond};
use crate::decompose::Cover;
use hullmap_geometry::number::{percent, short};

/// Thickness, relative to the object's diagonal, below which bodies pass through a part. For a body
/// of 1 m, Rapier lets resting bodies overlap by 1 mm, and Jolt by 20 mm.
pub const THIN: f64 = 1e-3;

/// Ratio of a protrusion to the requested one up to which rounding may explain the difference.
const ROOM: f64 = 1.0 + 1e-6;

/// Thickness of a hull: of a plate with its volume and its surface area. It is at least two thirds,
/// and at most twice, the radius of the largest ball in the hull. 0 below rank 3.
pub fn thickness(volume: f64, surface_area: f64) -> f64 {
    if surface_area > 0.0 { 2.0 * volume / surface_area } else { 0.0 }
}

/// The measures of one part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartMeasures<'a> {
    /// Its name.
    pub name: &'a str,
    /// See [`thickness`].
    pub thickness: f64,
    /// Bound on how far it protrudes; `None` if it was not measured.
    pub protrusion: Option<f64>,
}

/// The measures of the parts of one object. Lengths are in one unit.
#[derive(Clone, Copy, Debug)]
pub struct ObjectMeasures<'a> {
    /// Name of the object.
    pub name: &'a str,
    /// Diagonal of the box around it.
    pub diagonal: f64,
    /// How its solid is known; `None` if the parts were not measured.
    pub solid: Option<SolidKind>,
    /// Bound on how far its surface lies outside all parts; 0 if they were not measured.
    pub uncovered: f64,
    /// How much the parts overlap, relative to the volume of their union; `None` if it was not
    /// measured.
    pub overlap: Option<f64>,
    /// Its error: see [`Looseness`](crate::fit::Looseness).
    pub overlap_error: f64,
    /// The parts.
    pub parts: &'a [PartMeasures<'a>],
    /// Whether the object was cut into these parts. Otherwise the only part is its own hull.
    pub is_cut: bool,
    /// The parameters with which they were made; `None` for parts from elsewhere.
    pub cover: Option<&'a Cover>,
}

/// A property of parts that an engine cannot use well.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flaw {
    /// Parts are thin.
    Thin,
    /// Parts protrude more than requested.
    Protruding,
    /// Parts overlap more than requested.
    Overlapping,
    /// The parts do not cover the whole surface.
    Uncovered,
}

impl Flaw {
    /// The flaw in one word.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Thin => "thin",
            Self::Protruding => "protruding",
            Self::Overlapping => "overlapping",
            Self::Uncovered => "uncovered",
        }
    }
}

/// A flaw, a warning that gives its remedy, and the parts that have it.
#[derive(Clone, Debug, PartialEq)]
pub struct Doubt {
    /// The flaw.
    pub flaw: Flaw,
    /// The warning.
    pub remark: Remark,
    /// Indices of the parts.
    pub parts: Vec<usize>,
}

/// All flaws of the parts of an object; empty if an engine can use them.
pub fn doubts(object: &ObjectMeasures) -> Vec<Doubt> {
    [thin, protruding, overlapping, uncovered].into_iter().filter_map(|find| find(object)).collect()
}

fn thin(object: &ObjectMeasures) -> Option<Doubt> {
    let ObjectMeasures { name, diagonal, parts, .. } = *object;
    // NaN is thin.
    let is_thin = |index: &usize| !(parts[*index].thickness >= THIN * diagonal);
    let found: Vec<usize> = (0..parts.len()).filter(is_thin).filter(|_| object.is_cut).collect();
    let thinnest = found.iter().map(|index| parts[*index]).min_by(|a, b| a.thickness.total_cmp(&b.thickness))?;
    let remedy = match (object.cover, object.solid) {
        (None, _) => "thicken them, or decompose the mesh with --decompose",
        (Some(_), Some(SolidKind::Walls)) => {
            "the solid of the mesh is its walls, so its parts are as thick as --set wall and half of --max-error allow; \
             increase both, thicken the mesh, or leave it out if it is a decal"
        }
        (Some(_), _) => {
            "the decomposition made them, the mesh is not at fault; try another --max-error (thin parts become at most \
             half of it thick), or increase --set wall or --max-vertices"
        }
    };
    let (few, many) = (found.len(), parts.len());
    let verb = if few == 1 { "is" } else { "are" };
    let text = format!(
        "{name}: {few} of {many} parts {verb} thinner than {} of the diagonal, so bodies may pass through; the thinnest, {}, \
         is {} thick: {remedy}",
        percent(THIN),
        thinnest.name,
        short(thinnest.thickness),
    );
    let weight = few as f64;
    let remark = Remark { weight, ..Remark::warning("thin parts", name, text) };
    Some(Doubt { flaw: Flaw::Thin, remark, parts: found })
}

/// With a maximum number of parts, the error is an output, and no protrusion up to [`FAR`] is a
/// flaw.
fn protruding(object: &ObjectMeasures) -> Option<Doubt> {
    let remark = excess(object).filter(|remark| remark.is_warning)?;
    let cover = object.cover?;
    let requested = cover.max_error.resolve(object.diagonal) * ROOM;
    let allowed = cover.max_parts.map_or(requested, |_| requested.max(FAR * object.diagonal));
    let is_beyond = |index: &usize| object.parts[*index].protrusion.is_some_and(|bound| bound > allowed);
    let parts = (0..object.parts.len()).filter(is_beyond).collect();
    Some(Doubt { flaw: Flaw::Protruding, remark, parts })
}

/// Remark about parts that protrude more than the maximum error of their cover: a warning, or a
/// note if that error is an output.
pub fn excess(object: &ObjectMeasures) -> Option<Remark> {
    let cover = object.cover?;
    let reached = object.parts.iter().filter_map(|part| part.protrusion).fold(0.0, f64::max);
    let requested = cover.max_error.resolve(object.diagonal);
    let lengths = [reached, requested, object.diagonal];
    (reached > requested * ROOM).then(|| beyond(object.name, cover.max_parts, cover.seconds.is_some(), lengths))
}

/// Overlap from which parts do harm, relative to the volume of their union. Shells of a mesh that
/// cross each other overlap as they are.
const OVERLAPPING: f64 = 0.2;

fn overlapping(object: &ObjectMeasures) -> Option<Doubt> {
    let found = object.overlap.filter(|_| object.cover.is_some())?;
    if found <= OVERLAPPING + object.overlap_error {
        return None;
    }
    let name = object.name;
    let text = format!(
        "{name}: the parts overlap by {} of the volume of their union, more than {}, and an engine finds contacts \
         there twice; increase --max-vertices, or try another --max-error",
        percent(found),
        percent(OVERLAPPING),
    );
    let remark = Remark { weight: found, ..Remark::warning("overlapping parts", name, text) };
    Some(Doubt { flaw: Flaw::Overlapping, remark, parts: (0..object.parts.len()).collect() })
}

fn uncovered(object: &ObjectMeasures) -> Option<Doubt> {
    let ObjectMeasures { name, diagonal, uncovered, .. } = *object;
    // NaN is not covered.
    if uncovered <= COVERED * diagonal {
        return None;
    }
    let remedy = match object.cover {
        Some(_) => "try another --max-error, and please report this mesh",
        None => "decompose the mesh with --decompose, or extend the parts",
    };
    let text = format!("{name}: the surface lies up to {} outside all parts; to cover it, {remedy}", short(uncovered));
    let remark = Remark { weight: uncovered / diagonal, ..Remark::warning("uncovered surface", name, text) };
    Some(Doubt { flaw: Flaw::Uncovered, remark, parts: (0..object.parts.len()).collect() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{advice::summarise, decompose::Length, fit::SolidRule};

    const PART: PartMeasures = PartMeasures { name: "a_part_0", thickness: 0.02, protrusion: Some(0.03) };
    const SOUND: ObjectMeasures = ObjectMeasures {
        name: "a",
        diagonal: 2.0,
        solid: Some(SolidKind::Watertight),
        uncovered: 1e-8,
        overlap: Some(0.2005),
        overlap_error: 0.001,
        parts: &[PART, PartMeasures { name: "a_part_1", ..PART }],
        is_cut: true,
        cover: Some(&COVER),
    };
    const COVER: Cover = Cover {
        max_error: Length::Relative(0.02),
        max_parts: None,
        max_vertices: Some(64),
        solid: SolidRule::Auto,
        wall: Length::Relative(0.005),
        seconds: None,
    };

    fn flaws(object: &ObjectMeasures) -> Vec<(Flaw, Vec<usize>)> {
        doubts(object).into_iter().map(|doubt| (doubt.flaw, doubt.parts)).collect()
    }

    fn words(object: &ObjectMeasures) -> String {
        summarise(doubts(object).into_iter().map(|doubt| doubt.remark)).1.join("|")
    }

    #[test]
    fn sound_parts_raise_no_doubt() {
        assert_eq!(flaws(&SOUND), []);
        let elsewhere = ObjectMeasures { cover: None, overlap: Some(3.0), ..SOUND };
        assert_eq!(flaws(&elsewhere), [], "nothing was requested of parts from elsewhere");
        let plate = thickness(1.0 * 1.0 * 1e-4, 2.0 + 4.0 * 1e-4);
        assert!((plate - 1e-4).abs() < 1e-7 && thickness(0.0, 0.0) == 0.0, "{plate}");
    }

    #[test]
    fn a_sliver_is_blamed_on_its_maker() {
        let sliver = PartMeasures { name: "a_part_1", thickness: 1.9e-3, ..PART };
        let parts = [PART, sliver];
        let made = ObjectMeasures { parts: &parts, ..SOUND };
        assert_eq!(flaws(&made), [(Flaw::Thin, vec![1])]);
        let start = "a: 1 of 2 parts is thinner than 0.1% of the diagonal, so bodies may pass through; the thinnest";
        for (object, remedy) in [
            (made, "the mesh is not at fault; try another --max-error"),
            (
                ObjectMeasures { solid: Some(SolidKind::Walls), ..made },
                "thicken the mesh, or leave it out if it is a decal",
            ),
            (ObjectMeasures { cover: None, ..made }, "thicken them, or decompose"),
        ] {
            let text = words(&object);
            assert!(text.starts_with(start) && text.contains(remedy), "{text}");
        }
        assert!(!words(&made).contains("decal"));
        assert_eq!(flaws(&ObjectMeasures { is_cut: false, parts: &parts[1..], ..made }), [], "the mesh itself");
        let parts = [PartMeasures { thickness: f64::NAN, ..PART }];
        assert_eq!(flaws(&ObjectMeasures { parts: &parts, ..SOUND }), [(Flaw::Thin, vec![0])]);
    }

    #[test]
    fn more_than_was_requested_is_a_doubt() {
        let parts = [PartMeasures { protrusion: Some(0.05), ..PART }, PART];
        let far = ObjectMeasures { parts: &parts, ..SOUND };
        assert_eq!(flaws(&far), [(Flaw::Protruding, vec![0])]);
        assert!(words(&far).contains("a: parts protrude by 0.05 (2.5% of the diagonal) instead of 0.04:"));
        let few = Cover { max_parts: Some(2), ..COVER };
        let few = ObjectMeasures { cover: Some(&few), ..far };
        assert_eq!(flaws(&few), []);
        assert!(excess(&few).unwrap().text.contains("with at most 2 parts"));
        let parts =
            [PartMeasures { protrusion: Some(0.101), ..PART }, PartMeasures { protrusion: Some(0.099), ..PART }];
        let too_few = ObjectMeasures { parts: &parts, ..few };
        assert_eq!(flaws(&too_few), [(Flaw::Protruding, vec![0])]);
        assert!(words(&too_few).contains("is 0.101 (5.05% of the diagonal) instead of 0.04, so bodies collide"));
        let loose = ObjectMeasures { overlap: Some(0.227), ..SOUND };
        assert_eq!(flaws(&loose), [(Flaw::Overlapping, vec![0, 1])]);
        assert!(words(&loose).contains("overlap by 22.7% of the volume of their union, more than 20%"));
        for uncovered in [1e-6, f64::NAN] {
            let open = ObjectMeasures { uncovered, ..SOUND };
            assert_eq!(flaws(&open), [(Flaw::Uncovered, vec![0, 1])]);
        }
    }
}
