//! Small hulls and boxes in degenerate poses; the solver is compared with their exact depth.

use std::{cmp::Ordering, collections::BTreeMap, fmt};

use glam::{DQuat, DVec3};
use hullmap::{
    Cache, Contact, Hull, Overlap, Pack, Pose, Settings, Status, SupportMap, contact, intersects, shapes::Cuboid,
    solver::contact_by_facets,
};
use hullmap_testkit::{
    exact_depth::{Depth, depth},
    faceless::Faceless,
    packs,
    polytope::height_over_faces,
    random::RandomPoses,
};
use shapes::{families, rng::SplitMix64};

use crate::soak::body::Any;

/// How the bodies lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Any bodies, anywhere.
    Random,
    /// Turned by 1e-3 to 1e-9 from a quarter turn, some far from the origin of their frame:
    /// features are nearly parallel.
    NearlyParallel,
    /// Plates of 1:100 and of 1:10,000, flat on each other or crossed, nearly or exactly.
    Plates,
    /// Boxes turned by quarter turns: faces and edges are parallel.
    AlignedBoxes,
    /// Interior points coincide. Half of the bodies B are a quarter of the size of A.
    Concentric,
    /// Depths of 1e-4 to 1e-16 of the size, also negative ones.
    Touching,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 6] =
        [Self::Random, Self::NearlyParallel, Self::Plates, Self::AlignedBoxes, Self::Concentric, Self::Touching];
}

/// A pair by its seed and number: two packs of one hull each, and a pose.
pub struct Meeting {
    /// How the bodies lie.
    pub kind: Kind,
    packs: [Pack; 2],
    /// The boxes that the hulls are, if they are.
    cuboids: [Option<Cuboid>; 2],
    /// Pose of B in A's frame.
    pub b_in_a: Pose,
}

/// The corners of a box; the first is in the direction of all axes.
fn of_box(half: [f32; 3]) -> Vec<[f32; 3]> {
    (0..8).map(|corner| [0, 1, 2].map(|axis| if corner >> axis & 1 == 0 { half[axis] } else { -half[axis] })).collect()
}

/// A body of at most `most` ≥ 24 points.
fn points(kind: Kind, most: usize, rng: &mut SplitMix64) -> Vec<[f32; 3]> {
    let count = 8 + rng.below(most - 7);
    let seed = rng.next_u64();
    let plate = |rng: &mut SplitMix64| of_box([1.0, 1.0, [1e-2, 1e-4][rng.below(2)]]);
    match (kind, rng.below(6)) {
        (Kind::Plates, _) => plate(rng),
        (Kind::AlignedBoxes, _) | (_, 0) => of_box([1.0, [1.0, 0.75][rng.below(2)], [1.0, 0.5][rng.below(2)]]),
        (_, 1) => plate(rng),
        (_, 2) => families::prism(8 + 2 * rng.below(5), 0),
        (_, 3) => families::sphere(count, seed),
        (_, 4) => families::clustered_ellipsoid(count, seed),
        _ => families::rock(count, seed),
    }
}

impl Meeting {
    /// Pair `index` of the series of `seed`, of hulls of at most `most` ≥ 24 vertices.
    pub fn new(seed: u64, index: u64, most: usize) -> Self {
        let mut rng = SplitMix64::new(seed ^ index << 24);
        let kind = Kind::ALL[index as usize % Kind::ALL.len()];
        let scale = [1.0, 1.0, 1e-3, 1e3, 1e-6, 1e6][rng.below(6)];
        let small = if kind == Kind::Concentric && rng.below(2) == 0 { 0.25 } else { 1.0 };
        let bodies = [1.0, small].map(|size| {
            let shift = if rng.below(4) == 0 { [40.0, -24.0, 8.0] } else { [0.0; 3] };
            let place = |p: [f32; 3]| [0, 1, 2].map(|axis| (p[axis] * size + shift[axis]) * scale);
            let points = points(kind, most, &mut rng);
            let is_box = shift == [0.0; 3] && points[..] == of_box(points[0]);
            let points: Vec<[f32; 3]> = points.into_iter().map(place).collect();
            let half = DVec3::from_array(points[0].map(f64::from));
            (packs::tree_pack(&points), is_box.then(|| Cuboid::new(half).expect("lengths")))
        });
        let [(first, cuboid_a), (second, cuboid_b)] = bodies;
        let (packs, cuboids) = ([first, second], [cuboid_a, cuboid_b]);
        let [a, b] = packs.each_ref().map(|pack| pack.hull(0).expect("a pack has a hull"));
        let b_in_a = pose(kind, &a, &b, &mut rng);
        Self { kind, packs, cuboids, b_in_a }
    }

    /// A and B.
    pub fn hulls(&self) -> [Hull<'_>; 2] {
        self.packs.each_ref().map(|pack| pack.hull(0).expect("a pack has a hull"))
    }
}

fn pose(kind: Kind, a: &Hull<'_>, b: &Hull<'_>, rng: &mut SplitMix64) -> Pose {
    let axis = |rng: &mut SplitMix64| [DVec3::X, DVec3::Y, DVec3::Z][rng.below(3)];
    let quarter = |rng: &mut SplitMix64| {
        let axis = axis(rng);
        DQuat::from_axis_angle(axis, std::f64::consts::FRAC_PI_2 * rng.below(4) as f64)
    };
    let nearly = |rng: &mut SplitMix64| {
        let turn = 10_f64.powf(rng.between(-9.0, -3.0));
        DQuat::from_axis_angle(rng.unit_vector(), turn) * quarter(rng)
    };
    let rotation = match (kind, rng.below(2)) {
        (Kind::Random, _) | (Kind::Concentric | Kind::Touching, 0) => rng.rotation(),
        (Kind::NearlyParallel, _) | (Kind::Plates, 0) => nearly(rng),
        _ => quarter(rng),
    };
    let direction = if rng.below(2) == 0 { axis(rng) } else { rng.unit_vector() };
    let from = a.interior_point() - rotation * b.interior_point();
    let at = |t: f64| Pose::new(from + direction * t, rotation).expect("the pose is finite");
    let reach = a.outer_radius() + b.outer_radius();
    match kind {
        Kind::Concentric => at(0.0),
        Kind::Touching => {
            let depth_at = |t: f64| depth_bound(a, b, at(t));
            let (mut inside, mut outside) = (0.0, reach);
            for _ in 0..60 {
                let middle = 0.5 * (inside + outside);
                if depth_at(middle) > 0.0 { inside = middle } else { outside = middle }
            }
            let off = reach * 10_f64.powf(rng.between(-16.0, -4.0));
            at(inside + off * [-1.0, 1.0][rng.below(2)])
        }
        _ => at(reach * rng.between(0.0, 0.7)),
    }
}

/// Depth in f64, good enough to find a pose.
fn depth_bound(a: &Hull<'_>, b: &Hull<'_>, b_in_a: Pose) -> f64 {
    let found = contact(a, b, b_in_a, &Settings::default(), &mut Cache::new());
    if found.hit { found.depth } else { -1.0 }
}

/// Largest distance of a witness point from the surface of its hull, and from its place along the
/// normal beyond the width of the interval, over the size of the query.
const NEAR: f64 = 4e-12;

/// The path of the separating axis test.
const BY_FACETS: &str = "by facets";

/// Counts of one kind of pose.
#[derive(Clone, Copy, Debug, Default)]
pub struct Count {
    /// Pairs.
    pub pairs: u64,
    /// Pairs that penetrate, exactly.
    pub penetrating: u64,
    /// Answers that were compared with the truth.
    pub answers: u64,
    /// Questions to the separating axis test: for hulls, and for the boxes that they are.
    pub asked: u64,
    /// Its answers.
    pub by_facets: u64,
    /// Largest distance of a witness point from the surface of its hull, over the query's size.
    pub worst_witness: f64,
    /// Largest distance of a witness point from the witness point of the other hull, moved by the
    /// depth along the normal, beyond the width of the interval, over the size of the query.
    pub worst_offset: f64,
}

/// All counts, and the wrong answers in full.
#[derive(Default)]
pub struct Tally {
    /// By kind of pose.
    pub counts: BTreeMap<Kind, Count>,
    /// Wrong answers.
    pub misses: Vec<String>,
}

impl Tally {
    /// Solves a pair of hulls of at most `most` vertices by all paths, cold and warm, and judges
    /// the answers.
    pub fn judge(&mut self, seed: u64, index: u64, most: usize) {
        let meeting = Meeting::new(seed, index, most);
        let ([a, b], b_in_a) = (meeting.hulls(), meeting.b_in_a);
        let truth = depth(&a, &b, b_in_a);
        let what = format!("seed {seed}, pair {index}, {:?}, {b_in_a:?}", meeting.kind);
        let exact = Settings { tolerance: 0.0, ..Settings::default() };
        let mut cache = Cache::new();
        let hulls: [&Any<'_>; 2] = [&a, &b];
        let boxes = meeting.cuboids.each_ref().map(|cuboid| cuboid.as_ref().map(|cuboid| -> &Any<'_> { cuboid }));
        let [all_a, all_b] = [0, 1].map(|i| [Some(hulls[i]), boxes[i]].into_iter().flatten());
        let pairs = all_a.flat_map(|a| all_b.clone().map(move |b| (a, b)));
        let facets: Vec<Option<Contact>> = pairs.map(|(a, b)| contact_by_facets(a, b, b_in_a, &exact)).collect();
        let (hidden_a, hidden_b): (&Any<'_>, &Any<'_>) = (&Faceless(a), &Faceless(b));
        let mut answers = vec![
            ("cold", contact(&a, &b, b_in_a, &Settings::default(), &mut Cache::new())),
            ("tolerance 0", contact(&a, &b, b_in_a, &exact, &mut cache)),
            ("warm", contact(&a, &b, b_in_a, &exact, &mut cache)),
            ("general", contact(hidden_a, hidden_b, b_in_a, &exact, &mut Cache::new())),
        ];
        answers.extend(facets.iter().flatten().map(|found| (BY_FACETS, *found)));
        let count = self.counts.entry(meeting.kind).or_default();
        count.pairs += 1;
        count.penetrating += u64::from(truth.sign() == Ordering::Greater);
        count.answers += answers.len() as u64;
        count.asked += facets.len() as u64;
        count.by_facets += facets.iter().flatten().count() as u64;
        let size = a.outer_radius() + b.outer_radius() + a.interior_point().length() + b.interior_point().length();
        for (path, found) in answers {
            let fault = fault_of(&found, &truth);
            let fault = fault.or_else(|| if path == BY_FACETS { rough(&found, &truth, size) } else { None });
            if let Some(fault) = fault {
                self.misses.push(format!("{what}, {path}: {fault}: {found:?}"));
            }
            if found.hit && found.depth > 0.0 {
                let (back, size) = (b_in_a.inverse(), size + b_in_a.translation().length());
                let heights = [(&a, found.point_a), (&b, back.transform_point(found.point_b))];
                let surface = heights.map(|(hull, point)| height_over_faces(hull, point).abs());
                let surface = surface[0].max(surface[1]);
                let width = found.depth_upper - found.depth_lower;
                let offset = (found.point_a - found.point_b).distance(found.normal * found.depth) - width;
                let [surface, offset] = [surface, offset].map(|length| length / size);
                count.worst_witness = count.worst_witness.max(surface);
                count.worst_offset = count.worst_offset.max(offset);
                let is_settled = matches!(found.status, Status::Exact | Status::Within);
                // NaN takes the failing branch.
                if !(surface <= NEAR) || is_settled && !(offset <= NEAR) {
                    let off = format!("{surface:e} off their surfaces, {offset:e} off the normal");
                    self.misses.push(format!("{what}, {path}: the witness points are {off}: {found:?}"));
                }
            }
        }
        let answer = intersects(&a, &b, b_in_a, &mut Cache::new()).status;
        let is_wrong = match answer {
            Overlap::Overlapping => truth.sign() == Ordering::Less,
            Overlap::Separated => truth.sign() != Ordering::Less,
            _ => false,
        };
        if is_wrong {
            self.misses.push(format!("{what}: intersects says {answer:?}, the truth is {:?}", truth.sign()));
        }
    }
}

/// Fault of an answer; `None` if it is right.
fn fault_of(found: &Contact, truth: &Depth) -> Option<&'static str> {
    if !found.hit {
        return (truth.sign() != Ordering::Less).then_some("a hit is missed");
    }
    if found.depth_lower > 0.0 && truth.compare(found.depth_lower) == Ordering::Less {
        return Some("the lower bound is above the depth");
    }
    if truth.compare(found.depth_upper) == Ordering::Greater {
        return Some("the upper bound is below the depth");
    }
    // NaN takes the failing branch.
    let is_ordered = found.depth_lower <= found.depth && found.depth <= found.depth_upper;
    (!is_ordered).then_some("the depth is outside its interval")
}

/// Fault of a hit of the separating axis test, which always settles the depth to within rounding
/// errors.
fn rough(found: &Contact, truth: &Depth, size: f64) -> Option<&'static str> {
    let settled = matches!(found.status, Status::Exact | Status::Within) && found.depth_lower > 0.0;
    let is_near = truth.compare(found.depth + NEAR * size).is_le() && truth.compare(found.depth - NEAR * size).is_ge();
    let is_unit = (found.normal.length() - 1.0).abs() < 1e-14;
    (found.hit && !(settled && is_near && is_unit)).then_some("the depth by facets is rough")
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (kind, count) in &self.counts {
            let Count { pairs, penetrating, answers, asked, by_facets, worst_witness, worst_offset } = count;
            writeln!(
                f,
                "{kind:?}: {pairs} pairs, {penetrating} penetrate; {answers} answers, {by_facets} of {asked} by facets; witness \
                 points at most {worst_witness:.1e} of the size off their surfaces, and {worst_offset:.1e} off the normal"
            )?;
        }
        write!(f, "{} wrong", self.misses.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrong_answers_are_misses() {
        let mut wrong = 0;
        for index in 0..24 {
            let meeting = Meeting::new(5, index, 24);
            let ([a, b], b_in_a) = (meeting.hulls(), meeting.b_in_a);
            let truth = depth(&a, &b, b_in_a);
            let found = contact(&a, &b, b_in_a, &Settings::default(), &mut Cache::new());
            assert_eq!(fault_of(&found, &truth), None);
            if truth.sign() != Ordering::Greater || found.depth_lower == 0.0 {
                continue;
            }
            let width = 2.0 * (found.depth_upper - found.depth_lower);
            let high = Contact { depth_lower: found.depth_lower + width, ..found };
            let low = Contact { depth_upper: found.depth_upper - width, ..found };
            let missed = Contact { hit: false, ..found };
            let outside = Contact { depth: found.depth_upper + width, ..found };
            for answer in [high, low, missed, outside] {
                assert!(fault_of(&answer, &truth).is_some(), "{answer:?}");
                wrong += 1;
            }
        }
        assert!(wrong > 40, "{wrong}");
    }
}
