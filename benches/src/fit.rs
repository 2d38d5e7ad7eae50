//! Least-squares fits of measured times: the paper's equation 3, and the exponent of n.

/// The time of `tests` collision tests on hulls of `n` vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Vertices of a hull.
    pub n: f64,
    /// Collision tests.
    pub tests: f64,
    /// Their time, in nanoseconds.
    pub time_ns: f64,
}

/// t = n · c, with the factor that the paper omits: nanoseconds for each vertex and test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proportional {
    /// Nanoseconds for each vertex and test.
    pub factor_ns: f64,
    /// Fraction of the variance explained by the line.
    pub r_squared: f64,
}

/// t = c · (a + b · n).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    /// Nanoseconds for each test.
    pub per_test_ns: f64,
    /// Nanoseconds for each vertex and test.
    pub per_vertex_ns: f64,
    /// Fraction of the variance explained by the line.
    pub r_squared: f64,
}

/// Least squares of time against n · tests, through the origin.
pub fn proportional(samples: &[Sample]) -> Proportional {
    let (mut xx, mut xy) = (0.0, 0.0);
    for s in samples {
        let x = s.n * s.tests;
        xx += x * x;
        xy += x * s.time_ns;
    }
    let factor_ns = xy / xx;
    Proportional { factor_ns, r_squared: r_squared(samples, |s| factor_ns * s.n * s.tests) }
}

/// Least squares of time against tests and n · tests.
pub fn affine(samples: &[Sample]) -> Affine {
    // Normal equations of t = a·tests + b·(n·tests).
    let (mut uu, mut uv, mut vv, mut ut, mut vt) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for s in samples {
        let (u, v) = (s.tests, s.n * s.tests);
        uu += u * u;
        uv += u * v;
        vv += v * v;
        ut += u * s.time_ns;
        vt += v * s.time_ns;
    }
    let determinant = uu * vv - uv * uv;
    let per_test_ns = (ut * vv - vt * uv) / determinant;
    let per_vertex_ns = (uu * vt - uv * ut) / determinant;
    let predicted = |s: &Sample| s.tests * (per_test_ns + per_vertex_ns * s.n);
    Affine { per_test_ns, per_vertex_ns, r_squared: r_squared(samples, predicted) }
}

/// Slope of log time per test against log n, by least squares: 1 is proportional, 0 is flat.
pub fn exponent(samples: &[Sample]) -> f64 {
    let count = samples.len() as f64;
    let points: Vec<(f64, f64)> = samples.iter().map(|s| (s.n.ln(), (s.time_ns / s.tests).ln())).collect();
    let mean = points.iter().fold((0.0, 0.0), |(x, y), p| (x + p.0 / count, y + p.1 / count));
    let covariance: f64 = points.iter().map(|p| (p.0 - mean.0) * (p.1 - mean.1)).sum();
    let variance: f64 = points.iter().map(|p| (p.0 - mean.0).powi(2)).sum();
    covariance / variance
}

fn r_squared(samples: &[Sample], predicted: impl Fn(&Sample) -> f64) -> f64 {
    let mean = samples.iter().map(|s| s.time_ns).sum::<f64>() / samples.len() as f64;
    let total: f64 = samples.iter().map(|s| (s.time_ns - mean).powi(2)).sum();
    let left: f64 = samples.iter().map(|s| (s.time_ns - predicted(s)).powi(2)).sum();
    1.0 - left / total
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(time_ns: impl Fn(f64, f64) -> f64) -> Vec<Sample> {
        let ns = [8.0, 64.0, 512.0, 4096.0];
        let pairs = ns.into_iter().flat_map(|n| [1e3, 5e3, 1e4].map(|tests| (n, tests)));
        pairs.map(|(n, tests)| Sample { n, tests, time_ns: time_ns(n, tests) }).collect()
    }

    #[test]
    fn fits_recover_the_line() {
        let samples = samples(|n, tests| tests * (300.0 + 2.0 * n));
        let fit = affine(&samples);
        assert!((fit.per_test_ns - 300.0).abs() < 1e-6 && (fit.per_vertex_ns - 2.0).abs() < 1e-9, "{fit:?}");
        assert!(fit.r_squared > 1.0 - 1e-12);
        let through_origin = proportional(&samples);
        assert!((2.0..2.2).contains(&through_origin.factor_ns), "{through_origin:?}");
        assert!((0.99..1.0).contains(&through_origin.r_squared), "{through_origin:?}");
    }

    #[test]
    fn exponents_of_proportional_and_flat_times() {
        assert!((exponent(&samples(|n, tests| 3.0 * n * tests)) - 1.0).abs() < 1e-12);
        assert!(exponent(&samples(|_, tests| 700.0 * tests)).abs() < 1e-12);
    }
}
