//! Rays, shape casts and signed distances against the truth in f64.

use glam::DVec3;
use hullmap::{Cache, CastSettings, Motion, Pack, Ray, Settings, Status, SupportMap, cast, ray, signed_distance};
use hullmap_bake::{IndexKind, SourceRecord};
use hullmap_testkit::{
    entry::{Passage, passage, passage_of_point},
    packs::{self, point_set},
    polytope::{Polytope, rounding_error},
    random::RandomPoses,
    reach::Reach,
};
use shapes::{families::Family, rng::SplitMix64};

const SEED: u64 = 20_261_122;

fn pack(sets: &[(Family, usize)]) -> Pack {
    let sets: Vec<_> = sets.iter().map(|(family, n)| point_set(family.name(), &family.points(*n, *n as u64))).collect();
    Pack::from_bytes(&packs::bytes(&sets, IndexKind::Tree, &SourceRecord::default()).unwrap()).unwrap()
}

/// Hulls of rank 2 and 3.
const SETS: [(Family, usize); 14] = [
    (Family::Sphere, 8),
    (Family::Sphere, 128),
    (Family::Sphere, 2_000),
    (Family::Rock, 20),
    (Family::Rock, 400),
    (Family::ClusteredEllipsoid, 60),
    (Family::Prism, 13),
    (Family::RotatedPrism, 32),
    (Family::Cone, 20),
    (Family::Lens, 40),
    (Family::UvSphere, 62),
    (Family::CubeGrid, 27),
    (Family::FlatSheet, 20),
    (Family::Needle, 24),
];

/// A ray towards a shape: from inside, from its surface, at a vertex, an edge, a face, past it.
fn some_ray(rng: &mut SplitMix64, hull: &Polytope, center: DVec3, radius: f64) -> (DVec3, DVec3) {
    let vertex = |rng: &mut SplitMix64| hull.points[rng.below(hull.points.len())];
    let target = match rng.below(8) {
        0 => vertex(rng),
        1 => vertex(rng).lerp(vertex(rng), 0.5),
        2 => (vertex(rng) + vertex(rng) + vertex(rng)) / 3.0,
        3 => center,
        _ => center + rng.unit_vector() * radius * rng.between(0.0, 1.2),
    };
    let direction = match rng.below(8) {
        0 => DVec3::AXES[rng.below(3)],
        1 => vertex(rng) - vertex(rng),
        2 => vertex(rng) - target,
        _ => rng.unit_vector(),
    };
    let direction = if direction == DVec3::ZERO { DVec3::X } else { direction * rng.between(0.1, 3.0) };
    let back = match rng.below(8) {
        0 => 0.0,
        1 => rng.between(-1.0, 1.0) * radius,
        2 => 1e3 * radius,
        _ => rng.between(0.0, 6.0) * radius,
    };
    (target - direction.normalize() * back, direction)
}

struct Judged {
    hit: bool,
    status: Status,
    interval: [f64; 3],
    limit: f64,
}

#[derive(Default, Debug)]
struct Tally {
    misses: usize,
    statuses: std::collections::BTreeMap<&'static str, usize>,
    worst: f64,
    calls: [u64; 2],
}

impl Tally {
    /// `size` is the shapes' size in units of time.
    fn judge(&mut self, judged: &Judged, truth: &Passage, size: f64, slack: f64, details: &dyn Fn() -> String) {
        let Judged { hit, status, interval: [lower, at, upper], limit } = *judged;
        *self.statuses.entry(status.as_str()).or_default() += 1;
        let mut wrong = Vec::new();
        let enter = truth.enter.map(|t| t.max(0.0));
        if hit {
            if !(lower <= at && at <= upper && lower >= 0.0) {
                wrong.push("t is not in its own interval");
            }
            if truth.certainly_hits(limit) && !(lower <= enter[1] + slack && enter[0] - slack <= upper) {
                wrong.push("the interval does not contain the truth");
            }
            let certain = !matches!(status, Status::Touching);
            // The upper bound may be beyond the limit.
            if certain && truth.certainly_misses(limit.max(upper)) {
                wrong.push("a certain hit misses");
            }
            if status == Status::Overlapping && truth.enter[0] > 0.0 {
                wrong.push("the start is not inside");
            }
            if matches!(status, Status::Exact | Status::Within) && truth.certainly_hits(limit) {
                let off = (enter[0] - at).max(at - enter[1]).max(0.0) / size;
                if off > 1e-6 {
                    println!("off {off:e} {status} {lower:e} {at:e} {upper:e} truth {truth:?} {}", details());
                }
                self.worst = self.worst.max(off);
            }
            if matches!(status, Status::Stalled | Status::IterationLimit) && rand_print() {
                println!("{status} {lower:e} {at:e} {upper:e} truth {truth:?} {}", details());
            }
        } else if truth.certainly_hits(limit) {
            wrong.push("a certain miss hits");
        }
        for what in wrong {
            self.misses += 1;
            if self.misses < 6 {
                println!(
                    "{what}: {status} {lower:e} {at:e} {upper:e} limit {limit:e}, truth {truth:?}\n  {}",
                    details()
                );
            }
        }
    }
}

#[test]
fn rays_at_hulls() {
    let rounds: usize = std::env::var("ROUNDS").ok().and_then(|n| n.parse().ok()).unwrap_or(2_000);
    let pack = pack(&SETS);
    let mut total = 0;
    for (hull, (family, n)) in pack.hulls().zip(SETS) {
        let polytope = Polytope::new(&hull);
        let offsets: Vec<f64> = polytope.normals.iter().map(|n| polytope.reach(*n)).collect();
        let (mut rng, mut tally) = (SplitMix64::new(SEED), Tally::default());
        for round in 0..rounds {
            let (origin, direction) = some_ray(&mut rng, &polytope, hull.interior_point(), hull.outer_radius());
            let max_t = if round % 4 == 0 { rng.between(0.0, 4.0) } else { f64::INFINITY };
            let settings = CastSettings { max_t, ..CastSettings::default() };
            let found = ray(&hull, &Ray::new(origin, direction).unwrap(), &settings);
            let slack = 16.0 * f64::EPSILON * (polytope.greatest() + origin.length());
            let truth = passage_of_point(&polytope, &offsets, origin, direction, slack);
            let size = hull.outer_radius() / direction.length();
            let judged = Judged {
                hit: found.hit,
                status: found.status,
                interval: [found.t_lower, found.t, found.t_upper],
                limit: max_t,
            };
            tally.judge(&judged, &truth, size, 4.0 * slack / direction.length(), &|| {
                format!("{origin} {direction} {found:?}")
            });
            if found.hit {
                tally.calls[0] += u64::from(found.support_calls);
                tally.calls[1] += 1;
            }
        }
        println!("{} {n}: {tally:?} mean calls {:.1}", family.name(), tally.calls[0] as f64 / tally.calls[1] as f64);
        total += tally.misses;
    }
    assert_eq!(total, 0);
}

#[test]
fn casts_of_hulls() {
    let rounds: usize = std::env::var("ROUNDS").ok().and_then(|n| n.parse().ok()).unwrap_or(100);
    let pack = pack(&SETS);
    let mut rng = SplitMix64::new(SEED);
    let small: Vec<_> =
        pack.hulls().filter(|hull| hull.vertex_count() <= 64).map(|hull| (hull, Polytope::new(&hull))).collect();
    let mut total = 0;
    for (a, polytope_a) in &small {
        let mut tally = Tally::default();
        for (b, polytope_b) in &small {
            let mut cache = Cache::new();
            for round in 0..rounds {
                let far = rng.between(0.0, 4.0);
                let pose = rng.pose(far);
                let aim = -pose.translation() + rng.unit_vector() * rng.between(0.0, 1.5);
                let velocity = if round % 5 == 0 { rng.unit_vector() } else { aim };
                let max_t = if round % 3 == 0 { 1.0 } else { f64::INFINITY };
                let settings = CastSettings { max_t, ..CastSettings::default() };
                let found = cast(a, b, pose, Motion::new(velocity).unwrap(), &settings, &mut cache);
                let placed = polytope_b.placed(pose);
                let slack = rounding_error(polytope_a, &placed, pose.translation().length());
                let truth = passage(polytope_a, &placed, velocity, slack);
                let size = (a.outer_radius() + b.outer_radius()) / velocity.length();
                let judged = Judged {
                    hit: found.hit,
                    status: found.status,
                    interval: [found.t_lower, found.t, found.t_upper],
                    limit: max_t,
                };
                tally.judge(&judged, &truth, size, 4.0 * slack / velocity.length(), &|| {
                    format!("{pose:?} {velocity} {found:?}")
                });
                if found.hit {
                    tally.calls[0] += u64::from(found.support_calls);
                    tally.calls[1] += 1;
                }
            }
        }
        println!("{}: {tally:?} mean calls {:.1}", a.name(), tally.calls[0] as f64 / tally.calls[1] as f64);
        total += tally.misses;
    }
    assert_eq!(total, 0);
}

#[test]
fn points_at_hulls() {
    let pack = pack(&SETS);
    for hull in pack.hulls() {
        let mut cache = Cache::new();
        let mut rng = SplitMix64::new(SEED);
        for _ in 0..200 {
            let p = hull.interior_point() + rng.unit_vector() * hull.outer_radius() * rng.between(0.0, 2.0);
            let found = signed_distance(&hull, p, &Settings::default(), &mut cache).unwrap();
            assert!(found.lower <= found.distance && found.distance <= found.upper, "{found:?}");
        }
    }
}

fn rand_print() -> bool {
    use std::sync::atomic::{AtomicU32, Ordering};
    static N: AtomicU32 = AtomicU32::new(0);
    N.fetch_add(1, Ordering::Relaxed) < 12
}

#[test]
#[ignore]
fn speed() {
    for n in [32, 128, 512, 2_048, 8_192] {
        let pack = pack(&[(Family::Sphere, n), (Family::Rock, n)]);
        let hulls = [pack.hull(0).unwrap(), pack.hull(1).unwrap()];
        let mut rng = SplitMix64::new(SEED);
        let settings = CastSettings::default();
        let rays: Vec<Ray> = (0..4096)
            .map(|_| {
                let target = rng.unit_vector() * rng.between(0.0, 0.6);
                let from = rng.unit_vector() * 4.0;
                Ray::new(from, target - from).unwrap()
            })
            .collect();
        for hull in &hulls {
            let time = |what: &str, f: &mut dyn FnMut(usize) -> (u32, bool)| {
                let mut best = f64::INFINITY;
                let (mut calls, mut hits) = (0u64, 0u64);
                for _ in 0..9 {
                    let start = std::time::Instant::now();
                    (calls, hits) = (0, 0);
                    for i in 0..4096 {
                        let (c, h) = f(i);
                        calls += u64::from(c);
                        hits += u64::from(h);
                    }
                    best = best.min(start.elapsed().as_secs_f64() / 4096.0);
                }
                println!(
                    "{n} {} {what}: {:.0} ns, {:.1} calls, {hits} hits",
                    hull.name(),
                    best * 1e9,
                    calls as f64 / 4096.0
                );
            };
            time("ray", &mut |i| {
                let r = ray(hull, &rays[i], &settings);
                (r.support_calls, r.hit)
            });
            let poses: Vec<_> = rays
                .iter()
                .map(|r| (hullmap::Pose::new(r.origin(), rng.rotation()).unwrap(), Motion::new(r.direction()).unwrap()))
                .collect();
            time("cast", &mut |i| {
                let r = cast(hull, &hulls[1], poses[i].0, poses[i].1, &settings, &mut Cache::new());
                (r.support_calls, r.hit)
            });
            let mut cache = Cache::new();
            time("cast cache", &mut |i| {
                let r = cast(hull, &hulls[1], poses[i].0, poses[i].1, &settings, &mut cache);
                (r.support_calls, r.hit)
            });
            let round = hullmap::shapes::Rounded::new(*hull, 0.1).unwrap();
            time("ray rounded", &mut |i| {
                let r = ray(&round, &rays[i], &settings);
                (r.support_calls, r.hit)
            });
            time("point outside", &mut |i| {
                let r = signed_distance(hull, rays[i].origin() * 0.4, &Settings::default(), &mut Cache::new()).unwrap();
                (r.support_calls, r.distance > 0.0)
            });
            time("point inside", &mut |i| {
                let r = signed_distance(hull, rays[i].at(1.0), &Settings::default(), &mut Cache::new()).unwrap();
                (r.support_calls, r.distance > 0.0)
            });
        }
    }
    let egg =
        hullmap::shapes::Scaled::new(hullmap::shapes::Sphere::new(1.0).unwrap(), DVec3::new(1.0, 0.5, 2.0)).unwrap();
    let pill = hullmap::shapes::Cylinder::new(1.0, 0.5).unwrap();
    let ball = hullmap::shapes::Sphere::new(1.0).unwrap();
    let shapes: [(&str, &dyn SupportMap); 3] = [("egg", &egg), ("cylinder", &pill), ("ball", &ball)];
    let mut rng = SplitMix64::new(SEED);
    for (name, shape) in shapes {
        for tolerance in [1e-6, 1e-12, 0.0] {
            let (mut calls, mut most, mut hits, mut width) = (0, 0, 0, 0.0_f64);
            let start = std::time::Instant::now();
            for _ in 0..4096 {
                let target = rng.unit_vector() * rng.between(0.0, 0.6);
                let from = rng.unit_vector() * 4.0;
                let r = ray(
                    shape,
                    &Ray::new(from, target - from).unwrap(),
                    &CastSettings { tolerance, ..CastSettings::default() },
                );
                if r.hit {
                    calls += r.support_calls;
                    hits += 1;
                    most = most.max(r.support_calls);
                    width = width.max(r.t_upper - r.t_lower);
                }
            }
            println!(
                "{name} {tolerance:e}: {} ns, {:.1} calls, at most {most}, width {width:e}",
                start.elapsed().as_nanos() / 4096,
                f64::from(calls) / f64::from(hits)
            );
        }
    }
}
