//! Wrong answers, and the counts over all pairs.

use std::{collections::BTreeMap, fmt};

use hullmap::{Cache, Contact, Distance, Intersection, Overlap, Settings, Status, contact, distance, intersects};
use hullmap_testkit::{
    depth::{signed_depth, signed_depth_by_points},
    gap::{distance_by_features, gap},
    polytope::rounding_error,
    reach::way_out,
};

use super::scene::{Body, Class, ScenePair};

/// Depth or distance, relative to the mean diameter, above which a wrong answer about overlap is a
/// miss. Below, it is only counted.
pub const SURE: f64 = 1e-6;

/// Default tolerance: width of an interval relative to its upper bound.
pub const WIDTH: f64 = Settings::DEFAULT_TOLERANCE;

/// Relative width of a truth that is too loose to judge widths of [`WIDTH`].
pub const LOOSE: f64 = 0.1 * WIDTH;

/// Vertices of each hull up to which the slow twins judge the truth.
const TWIN_VERTICES: usize = 12;

/// Relative error of the slow twins, whose triangles can be arbitrarily thin.
const TWIN_ERROR: f64 = 1e-7;

/// A wrong answer. Lengths are in the pair's units.
#[derive(Clone, Debug)]
pub struct Miss {
    /// The failed check.
    pub what: &'static str,
    /// The pair.
    pub pair: ScenePair,
    /// Truth and answer.
    pub details: String,
}

impl fmt::Display for Miss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ScenePair { index, recipes, class, b_in_a } = &self.pair;
        let (t, r) = (b_in_a.translation(), b_in_a.rotation());
        write!(
            f,
            "{}: pair {index}, {class:?}\n  {:?}\n  {:?}\n  pose \"{} {} {} {} {} {} {}\"\n  {}",
            self.what, recipes[0], recipes[1], t.x, t.y, t.z, r.x, r.y, r.z, r.w, self.details
        )
    }
}

/// The solver's answers about a pair, with cold caches and default settings.
#[derive(Clone, Copy, Debug)]
pub struct Answers {
    /// Intersection.
    pub yes: Intersection,
    /// Contact.
    pub deep: Contact,
    /// Distance.
    pub near: Distance,
}

impl Answers {
    /// Queries the solver.
    pub fn to(pair: &ScenePair, bodies: [&Body; 2]) -> Self {
        let ([a, b], settings) = (&bodies.map(Body::hull), Settings::default());
        Self {
            yes: intersects(a, b, pair.b_in_a, &mut Cache::default()),
            deep: contact(a, b, pair.b_in_a, &settings, &mut Cache::default()),
            near: distance(a, b, pair.b_in_a, &settings, &mut Cache::default()),
        }
    }
}

/// The counts over all pairs.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Pairs judged.
    pub pairs: usize,
    /// Numbers of pairs and of truly overlapping pairs, by class.
    pub classes: BTreeMap<Class, [usize; 2]>,
    /// Pairs within [`SURE`] of touching.
    pub unsure: usize,
    /// Number of these that are wrong about overlap by more than the rounding error.
    pub unsure_wrong: usize,
    /// Undecided answers of `intersects`.
    pub undecided: usize,
    /// Contacts of pairs that overlap, by status.
    pub contacts: BTreeMap<&'static str, usize>,
    /// Distances of separated pairs, by status.
    pub distances: BTreeMap<&'static str, usize>,
    /// Contacts, and distances, of pairs that are not within [`SURE`] of touching.
    pub sure: [usize; 2],
    /// Number of these whose interval is wider than [`WIDTH`].
    pub wide: [usize; 2],
    /// Maximum relative width of a sure contact and of a sure distance.
    pub widest: [f64; 2],
    /// Distances whose truth is an interval wider than [`LOOSE`].
    pub loose_truths: usize,
    /// Truths compared with the slow twins: depths and distances.
    pub twins: [usize; 2],
    /// Maximum number of support calls of a contact.
    pub max_support_calls: u32,
    /// Pairs by family, each hull counted.
    pub families: BTreeMap<&'static str, usize>,
    /// All misses.
    pub misses: Vec<Miss>,
}

impl Tally {
    /// Judges the answers about a pair.
    pub fn judge(&mut self, pair: &ScenePair, bodies: [&Body; 2], answers: &Answers) {
        let [hull_a, hull_b] = &bodies.map(Body::hull);
        let (a, b) = (&bodies[0].polytope, &bodies[1].polytope.placed(pair.b_in_a));
        let slack = rounding_error(a, b, pair.b_in_a.translation().length());
        let size = 0.5 * (hull_a.diameter() + hull_b.diameter());
        let (depth, _) = signed_depth(a, b, -4.0 * slack);
        let far = (depth < slack).then(|| {
            let mut far = gap(a, b);
            // Near touching, the vector between the points is of the size of the rounding error.
            // The normals of the facets are more accurate.
            if far.upper - far.lower > LOOSE * far.upper {
                far.lower = far.lower.max(-signed_depth(a, b, f64::NEG_INFINITY).0);
            }
            far
        });
        let apart = depth < -slack;
        // Distance or depth of the pair.
        let clear = far.map_or(depth, |far| far.lower.max(depth.abs().min(slack)));
        let sure = clear > SURE * size && clear > 2.0 * slack;
        let mut miss = |what, details: String| self.misses.push(Miss { what, pair: *pair, details });

        let twins = [a, b].iter().all(|hull| hull.points.len() <= TWIN_VERTICES);
        if twins && !apart {
            let twin = signed_depth_by_points(&a.points, &b.points);
            self.twins[0] += 1;
            if !((twin - depth).abs() <= slack + TWIN_ERROR * depth) {
                miss("the truths about the depth differ", format!("{depth:e}, by points {twin:e}, slack {slack:e}"));
            }
        }
        if let (true, true, Some(far)) = (twins, apart, far) {
            let twin = distance_by_features(&a.points, &b.points);
            self.twins[1] += 1;
            let slack = slack + TWIN_ERROR * far.upper;
            if !(far.lower - slack <= twin && twin <= far.upper + slack) {
                miss("the truths about the distance differ", format!("{far:?}, by features {twin:e}, slack {slack:e}"));
            }
        }
        if let (true, Some(far)) = (apart, far) {
            self.loose_truths += usize::from(far.upper - far.lower > LOOSE * far.upper + 2.0 * slack);
        }

        let Answers { yes, deep, near } = answers;
        let near_hit = matches!(near.status, Status::Overlapping | Status::Touching);
        let truth = || format!("depth {depth:e}, gap {far:?}, slack {slack:e}, size {size:e}");

        self.undecided += usize::from(yes.status == Overlap::Undecided);
        let right = [yes.is_hit(), deep.hit, near_hit].map(|hit| hit != apart);
        if sure {
            let of = [
                "intersects is wrong about overlap",
                "contact is wrong about overlap",
                "distance is wrong about overlap",
            ];
            for (what, _) in of.into_iter().zip(right).filter(|(_, right)| !right) {
                miss(what, format!("{}\n  {yes:?}\n  {deep:?}\n  {near:?}", truth()));
            }
        } else {
            self.unsure += 1;
            self.unsure_wrong += usize::from(clear > 2.0 * slack && right.contains(&false));
        }

        if deep.hit {
            // In truth separated, within the tolerance of `sure`: the depth is 0.
            let depth = depth.max(0.0);
            if !(deep.depth_lower <= depth + slack && depth - slack <= deep.depth_upper) {
                miss("the depth's interval does not contain the truth", format!("{}\n  {deep:?}", truth()));
            }
            if !(0.0 <= deep.depth_lower && deep.depth_lower <= deep.depth && deep.depth <= deep.depth_upper) {
                miss("the depth is not in its own interval", format!("{}\n  {deep:?}", truth()));
            }
            let way = way_out(a, b, deep.normal);
            if !(way <= deep.depth_upper + slack) {
                miss("the contact's normal is not the way out", format!("{}, way {way:e}\n  {deep:?}", truth()));
            }
            *self.contacts.entry(deep.status.as_str()).or_default() += 1;
            self.max_support_calls = self.max_support_calls.max(deep.support_calls);
        } else if !(way_out(a, b, deep.normal) <= slack) {
            miss("the contact's axis does not separate", format!("{}\n  {deep:?}", truth()));
        }
        if let (Some(far), false) = (far, near_hit) {
            if !(near.lower <= far.upper + slack && far.lower - slack <= near.upper) {
                miss("the distance's interval does not contain the truth", format!("{}\n  {near:?}", truth()));
            }
            if !(0.0 <= near.lower && near.lower <= near.distance && near.distance <= near.upper) {
                miss("the distance is not in its own interval", format!("{}\n  {near:?}", truth()));
            }
            *self.distances.entry(near.status.as_str()).or_default() += 1;
        }
        if sure && (deep.hit || !near_hit) {
            let which = usize::from(!deep.hit);
            let [lower, upper] = [[deep.depth_lower, deep.depth_upper], [near.lower, near.upper]][which];
            // Rounding errors at both ends are not errors of the search.
            let width = (upper - lower - 2.0 * slack).max(0.0) / upper;
            self.sure[which] += 1;
            self.wide[which] += usize::from(!(width <= WIDTH));
            self.widest[which] = self.widest[which].max(width);
        }

        let counts = self.classes.entry(pair.class).or_default();
        counts[0] += 1;
        counts[1] += usize::from(!apart);
        self.pairs += 1;
        for recipe in &pair.recipes {
            *self.families.entry(recipe.family()).or_default() += 1;
        }
    }

    /// Share of the pairs that overlap in truth.
    pub fn overlapping(&self) -> f64 {
        self.classes.values().map(|[_, hits]| hits).sum::<usize>() as f64 / self.pairs as f64
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} pairs, {:.1} % overlap", self.pairs, 100.0 * self.overlapping())?;
        for (class, [pairs, hits]) in &self.classes {
            writeln!(f, "  {class:?}: {pairs}, of which {hits} overlap")?;
        }
        writeln!(f, "hulls: {:?}", self.families)?;
        writeln!(
            f,
            "truths judged by slow twins: {} depths, {} distances; {} distances with a loose truth",
            self.twins[0], self.twins[1], self.loose_truths
        )?;
        writeln!(
            f,
            "within {SURE:e} of touching: {}, {} of them wrong about overlap by more than the rounding error; {} undecided",
            self.unsure, self.unsure_wrong, self.undecided
        )?;
        for (name, which, statuses) in [("contacts", 0, &self.contacts), ("distances", 1, &self.distances)] {
            writeln!(
                f,
                "{name}: {statuses:?}; {} sure, of which {} are wider than {WIDTH:e} (maximum {:.1e})",
                self.sure[which], self.wide[which], self.widest[which]
            )?;
        }
        writeln!(f, "maximum support calls of a contact: {}", self.max_support_calls)?;
        let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
        self.misses.iter().for_each(|miss| *kinds.entry(miss.what).or_default() += 1);
        write!(f, "misses: {} {kinds:?}", self.misses.len())
    }
}
