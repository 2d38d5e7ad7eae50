//! The claims of one answer, and which of them are wrong.

use glam::DVec3;
use hullmap::{CastSettings, Impact};
use shapes::rng::SplitMix64;

use super::bodies::BodyPair;
use super::tally::{Tally, Wrong};

/// Rounding error of a certificate, in units of the greatest lengths times the f64 epsilon: a
/// rotated direction or point has an error of about 40, a dot product of a few, on each shape.
pub(super) const ROUNDING_UNITS: f64 = 64.0;

/// The claims of one answer, and the first wrong one.
pub(super) struct Claims<'t> {
    wrong: Option<(&'static str, f64, f64)>,
    tightest: f64,
    queries: &'static str,
    pub(super) tally: &'t mut Tally,
}

impl<'t> Claims<'t> {
    /// Claims of an answer, which is counted.
    pub(super) fn new(queries: &'static str, tally: &'t mut Tally) -> Self {
        tally.judged += 1;
        Self::uncounted(queries, tally)
    }

    pub(super) fn uncounted(queries: &'static str, tally: &'t mut Tally) -> Self {
        Self { wrong: None, tightest: 0.0, queries, tally }
    }

    pub(super) fn at_most(&mut self, what: &'static str, found: f64, limit: f64, slack: f64) {
        // NaN takes the failing branch.
        if !(found <= limit + slack) {
            self.wrong.get_or_insert((what, found, limit));
        } else if slack > 0.0 {
            self.tightest = self.tightest.max((found - limit) / slack);
        }
    }

    pub(super) fn demand(&mut self, what: &'static str, holds: bool) {
        self.at_most(what, f64::from(u8::from(!holds)), 0.0, 0.0);
    }

    /// A value is in its own interval.
    pub(super) fn ordered(&mut self, what: &'static str, [lower, value, upper]: [f64; 3]) {
        self.demand(what, lower <= value && value <= upper);
    }

    pub(super) fn unit(&mut self, normal: DVec3) {
        self.at_most("the normal has no unit length", (normal.length() - 1.0).abs(), 0.0, 1e-14);
    }

    pub(super) fn finish(self, pair: &BodyPair<'_, '_>, details: impl FnOnce() -> String) {
        self.tally.tightest = self.tally.tightest.max(self.tightest);
        let queries = self.queries;
        if let Some((what, found, limit)) = self.wrong {
            let details = format!("{pair} --queries {queries}\n  {found:e} above {limit:e}\n  {}", details());
            self.tally.take_wrong(Wrong { index: pair.index, what, details });
        }
    }
}

/// Powers of two by which a velocity is made slower: their squares, or the products with it,
/// underflow.
const SLOWER: [i32; 3] = [-100, -500, -900];

/// The same cast, slower by a power of two: only the times differ, and by that power.
pub(super) fn same_when_slow(
    judge: &mut Claims<'_>,
    rng: &mut SplitMix64,
    found: &Impact,
    velocity: DVec3,
    settings: &CastSettings,
    cast: impl Fn(DVec3, &CastSettings) -> Impact,
) {
    let scale = 2_f64.powi(SLOWER[rng.below(SLOWER.len())]);
    if velocity * scale / scale != velocity {
        // A component underflows.
        return;
    }
    let slow = cast(velocity * scale, &CastSettings { max_t: settings.max_t / scale, ..*settings });
    let [t_lower, t, t_upper] = [slow.t_lower, slow.t, slow.t_upper].map(|t| t * scale);
    let is_same = Impact { t_lower, t, t_upper, ..slow } == *found;
    judge.demand("a slow motion has another answer", is_same);
}
