//! Goals of the project: fractions of parry3d's time, by query and vertex count.

use super::engines::PairQuery;

/// Vertex counts with goals.
pub const COUNTS: [usize; 7] = [8, 32, 128, 512, 2_048, 8_192, 32_768];

/// Fractions of parry's time, cold, in the order of [`COUNTS`].
const CONTACT: [f64; 7] = [0.30, 0.30, 0.18, 0.095, 0.034, 0.012, 0.0042];
const INTERSECTS: [f64; 7] = [0.32, 0.23, 0.13, 0.046, 0.015, 0.0040, 0.0012];
const DISTANCE: [f64; 7] = [0.37, 0.27, 0.16, 0.066, 0.019, 0.0067, 0.0024];

/// Maximum vertex count at which a warm contact has to be faster than a cold one.
const WARM_CONTACT_UP_TO: usize = 8_192;

/// Maximum fraction of parry's time for a cold query; `None` without a goal.
pub fn cold(query: PairQuery, n: usize) -> Option<f64> {
    let column = COUNTS.iter().position(|&count| count == n)?;
    let row = match query {
        PairQuery::Contact => CONTACT,
        PairQuery::Intersects => INTERSECTS,
        PairQuery::Distance => DISTANCE,
    };
    Some(row[column])
}

/// Maximum fraction of its own cold time for a frame-coherent query; `None` without a goal.
pub fn warm(query: PairQuery, n: usize) -> Option<f64> {
    match query {
        PairQuery::Contact => (n <= WARM_CONTACT_UP_TO).then_some(0.5),
        PairQuery::Intersects => Some(0.9),
        PairQuery::Distance => Some(0.65),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_by_query_and_count() {
        assert_eq!(cold(PairQuery::Contact, 8), Some(0.30));
        assert_eq!(cold(PairQuery::Intersects, 8_192), Some(0.0040));
        assert_eq!(cold(PairQuery::Distance, 32_768), Some(0.0024));
        assert_eq!(cold(PairQuery::Distance, 100), None);
        assert_eq!(warm(PairQuery::Contact, 8_192), Some(0.5));
        assert_eq!(warm(PairQuery::Contact, 32_768), None);
    }
}
