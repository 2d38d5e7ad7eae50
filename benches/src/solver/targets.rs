//! Which fraction of parry3d's time is aimed at, by query and vertex count.

use super::engines::Query;

/// Vertex counts for which there are targets.
pub const COUNTS: [usize; 7] = [8, 32, 128, 512, 2_048, 8_192, 32_768];

/// Fractions of parry's time, cold, in the order of [`COUNTS`].
const CONTACT: [f64; 7] = [0.30, 0.30, 0.18, 0.095, 0.034, 0.012, 0.0042];
const INTERSECTS: [f64; 7] = [0.32, 0.23, 0.13, 0.046, 0.015, 0.0040, 0.0012];
const DISTANCE: [f64; 7] = [0.37, 0.27, 0.16, 0.066, 0.019, 0.0067, 0.0024];

/// Vertices from which a warm contact need not be faster than a cold one.
const WARM_CONTACT_UP_TO: usize = 8_192;

/// Fraction of parry's time that a cold query is to take; `None` where nothing was set.
pub fn cold(query: Query, n: usize) -> Option<f64> {
    let column = COUNTS.iter().position(|&count| count == n)?;
    let row = match query {
        Query::Contact => CONTACT,
        Query::Intersects => INTERSECTS,
        Query::Distance => DISTANCE,
    };
    Some(row[column])
}

/// Fraction of its own cold time that a frame-coherent query is to take; `None` where nothing was set.
pub fn warm(query: Query, n: usize) -> Option<f64> {
    match query {
        Query::Contact => (n <= WARM_CONTACT_UP_TO).then_some(0.5),
        Query::Intersects => Some(0.9),
        Query::Distance => Some(0.65),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_are_where_they_were_set() {
        assert_eq!(cold(Query::Contact, 8), Some(0.30));
        assert_eq!(cold(Query::Intersects, 8_192), Some(0.0040));
        assert_eq!(cold(Query::Distance, 32_768), Some(0.0024));
        assert_eq!(cold(Query::Distance, 100), None);
        assert_eq!(warm(Query::Contact, 8_192), Some(0.5));
        assert_eq!(warm(Query::Contact, 32_768), None);
    }
}
