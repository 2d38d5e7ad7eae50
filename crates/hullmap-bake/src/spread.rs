//! Evenly spread points of a fixed sequence, for estimates that are the same everywhere.
//!
//! # Reference
//! Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018.

/// Powers of the inverse of the root of x⁴ = x + 1.
const STEPS: [f64; 3] = [0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_3];

pub fn spread(k: usize) -> [f64; 3] {
    STEPS.map(|step| (0.5 + step * k as f64).fract())
}
