//! Compares the kernels with the processor and with brute force in f64, and tests damaged packs.
//! Without a Vulkan device, each test says so and passes; with `HULLMAP_REQUIRE_GPU=1` it fails.

#[expect(clippy::disallowed_methods, reason = "the environment selects how much is tested")]
mod scene;

use std::collections::BTreeMap;

use hullmap::glam::{DVec3, Vec3};
use hullmap::{Cache, Pack, Settings, SupportMap};
use hullmap_bake::IndexKind;
use hullmap_testkit::{
    depth::signed_depth,
    gap::gap,
    packs::{ALL_INDICES, reseal},
    polytope::{Polytope, rounding_error},
    random::RandomPoses,
};
use hullmap_wgpu::{
    Answer, AnswerRecord, Backend, Batch, Device, Error, IndexedPair, Query, SUPPORT_SHORTFALL, Status, SupportQuery,
};
use shapes::rng::SplitMix64;

const TOLERANCE: f32 = 1e-5;

fn solve<'b>(batch: &'b mut Batch<'_>, query: Query, pairs: &[IndexedPair]) -> &'b [Answer] {
    let settings = Settings { tolerance: f64::from(TOLERANCE), ..Settings::default() };
    match query {
        Query::Intersects => batch.intersects(pairs),
        Query::Distance => batch.distance(pairs, &settings),
        Query::Contact => batch.contact(pairs, &settings),
    }
    .expect("the device works")
}

const QUERIES: [Query; 3] = [Query::Intersects, Query::Distance, Query::Contact];

/// Whether one status proves an overlap and the other one a separation.
fn contradict(query: Query, proofs: [Status; 2]) -> bool {
    let overlaps = |status| status == Status::Overlapping || (query == Query::Contact && status == Status::Stalled);
    let is_apart = |status| status == Status::Separated || (query != Query::Contact && status == Status::Stalled);
    proofs.into_iter().any(overlaps) && proofs.into_iter().any(is_apart)
}

fn counts(answers: &[Answer]) -> BTreeMap<&'static str, usize> {
    let mut counts = BTreeMap::new();
    for answer in answers {
        *counts.entry(answer.status.as_str()).or_insert(0) += 1;
    }
    counts
}

/// Answers of the processor for the pairs of a batch. Their intervals are certified.
fn on_processor(pack: &Pack, query: Query, pairs: &[IndexedPair]) -> Vec<Answer> {
    solve(&mut Batch::new(pack, Backend::Cpu).unwrap(), query, pairs).to_vec()
}

/// Asserts that the intervals of answers meet, and that no proof contradicts another.
#[track_caller]
fn assert_agree(query: Query, found: &[Answer], expected: &[Answer], context: &str) {
    assert_eq!(found.len(), expected.len());
    for (at, (found, other)) in found.iter().zip(expected).enumerate() {
        let meet = found.lower <= other.upper && other.lower <= found.upper;
        let agree = meet && !contradict(query, [found.status, other.status]);
        assert!(agree, "{query:?}, {context}, pair {at}: {found:?}, {other:?}");
    }
}

/// On this device, and with kernels that round as fused operations of other devices do.
#[test]
fn kernels_agree_with_the_processor() {
    let devices = scene::devices();
    devices.iter().take(1).for_each(|device| println!("{}", device.description()));
    let mut different = 0;
    for index in ALL_INDICES {
        let pack = scene::pack(index);
        let mut pairs = scene::pairs(&pack, scene::pair_count(4_000), 1);
        pairs.extend(scene::touching_pairs(&pack, pairs.len() / 4, 21));
        for query in QUERIES.into_iter().filter(|_| !devices.is_empty()) {
            let expected = on_processor(&pack, query, &pairs);
            let bits = devices.iter().map(|device| {
                let mut batch = Batch::on(device, &pack).unwrap();
                let found = solve(&mut batch, query, &pairs);
                assert_agree(query, found, &expected, &format!("{index:?}"));
                println!("{index:?} {query:?}: {:?}", counts(found));
                batch.records().1.iter().map(AnswerRecord::bits).collect::<Vec<_>>()
            });
            if let [plain, fused] = &bits.collect::<Vec<_>>()[..] {
                different += plain.iter().zip(fused).filter(|(plain, fused)| plain != fused).count();
            }
        }
    }
    assert!(devices.is_empty() || different > 5_000, "fused kernels must compute something else: {different}");
}

/// The states on the device, frame by frame.
#[test]
fn warm_answers_mean_the_same_and_take_fewer_steps() {
    let Some(device) = scene::device() else { return };
    let pack = scene::pack(IndexKind::Tree);
    for query in QUERIES {
        let mut pairs = scene::pairs(&pack, 2_000, 15);
        pairs[5].b = 1_000;
        let (mut warm, mut cold) = (Batch::on(&device, &pack).unwrap(), Batch::on(&device, &pack).unwrap());
        warm.set_warm(true);
        let mut steps = [0; 2];
        for frame in 0..4 {
            solve(&mut warm, query, &pairs);
            solve(&mut cold, query, &pairs);
            assert_agree(query, warm.answers(), cold.answers(), &format!("frame {frame}"));
            assert_agree(query, warm.answers(), &on_processor(&pack, query, &pairs), &format!("frame {frame}"));
            if frame > 0 {
                let total = |batch: &Batch<'_>| batch.answers().iter().map(|answer| answer.steps).sum::<u32>();
                steps = [steps[0] + total(&warm), steps[1] + total(&cold)];
            }
            pairs = scene::a_frame_later(&pairs, 16 + frame);
        }
        println!("{query:?}: {} steps warm, {} cold", steps[0], steps[1]);
        assert!(steps[0] < steps[1], "{query:?}: {steps:?}");
        // Other pairs in the same places: the states belong to other hulls.
        let others = scene::pairs(&pack, pairs.len(), 20);
        assert_agree(query, solve(&mut warm, query, &others), &on_processor(&pack, query, &others), "other pairs");
    }
}

/// The reads of a pair are bounded, so that lavapipe does not end the loops of the pairs beside it.
#[test]
fn pairs_that_read_too_much_leave_the_others_alone() {
    let Some(device) = scene::device() else { return };
    let pack = scene::large_pack();
    let pairs = scene::pairs(&pack, 10_000, 22);
    let (mut batch, mut processor) = (Batch::on(&device, &pack).unwrap(), Batch::new(&pack, Backend::Cpu).unwrap());
    for query in QUERIES {
        let found = solve(&mut batch, query, &pairs);
        let counts = counts(found);
        println!("{query:?}: {counts:?}");
        assert!(counts["budget"] > 10, "{counts:?}");
        assert_agree(query, found, solve(&mut processor, query, &pairs), "seed 22");
    }
    let axis = [Vec3::Z, Vec3::NEG_Z].map(|dir| SupportQuery { hull: 0, dir });
    let expected = processor.support(&axis).unwrap().to_vec();
    for (found, expected) in batch.support(&axis).unwrap().iter().zip(expected) {
        assert!(found.is_certain && found.point.z == expected.point.z, "{found:?}, {expected:?}");
    }
}

/// Compares answers with points and planes found by Wolfe's algorithm in f64.
#[test]
fn intervals_hold_the_distance() {
    let devices = scene::devices();
    let Some(first) = devices.first() else { return };
    let pack = scene::pack(IndexKind::Tree);
    let hulls: Vec<_> = (0..pack.hull_count()).map(|index| pack.hull(index).unwrap()).collect();
    // The reference does not support segments and points.
    let polytopes: Vec<_> = hulls.iter().map(|hull| (hull.rank() >= 2).then(|| Polytope::new(hull))).collect();
    let mut pairs = scene::pairs(&pack, scene::pair_count(4_000), 2);
    let touching = scene::touching_pairs(&pack, pairs.len() / 4, 18);
    pairs.extend(touching);
    pairs.retain(|pair| [pair.a, pair.b].iter().all(|hull| polytopes[*hull as usize].is_some()));
    let mut batch = Batch::on(first, &pack).unwrap();
    let mut others = vec![solve(&mut batch, Query::Intersects, &pairs).to_vec()];
    for device in &devices[1..] {
        others.push(solve(&mut Batch::on(device, &pack).unwrap(), Query::Distance, &pairs).to_vec());
    }
    let answers = solve(&mut batch, Query::Distance, &pairs);
    let (mut widest, mut open) = (0.0_f64, 0);
    for (at, pair) in pairs.iter().enumerate() {
        let of = |hull: u32| polytopes[hull as usize].as_ref().unwrap();
        let (a, b) = (of(pair.a), of(pair.b).placed(pair.b_in_a));
        let truth = gap(a, &b);
        let slack = rounding_error(a, &b, 1.0);
        for answer in [&answers[at]].into_iter().chain(others.iter().map(|other| &other[at])) {
            let holds = answer.lower <= truth.upper + slack && truth.lower - slack <= answer.upper;
            assert!(holds, "pair {at}, seed 2: {answer:?} of {truth:?}");
            match answer.status {
                Status::Separated | Status::Stalled => assert!(truth.upper + slack > 0.0 && answer.upper > 0.0, "{at}"),
                Status::Overlapping => assert!(truth.lower <= slack, "pair {at}, seed 2: overlaps, but {truth:?}"),
                Status::Open | Status::Budget => assert_eq!(answer.lower, 0.0, "pair {at}"),
                Status::Rejected => panic!("pair {at} was rejected"),
            }
        }
        let reach = hulls[pair.a as usize].outer_radius() + hulls[pair.b as usize].outer_radius();
        widest = widest.max((answers[at].upper - answers[at].lower) / reach);
        open += usize::from(answers[at].status.is_unsettled());
    }
    let counts = counts(answers);
    println!("{counts:?}; the widest interval is {widest:.2e} of the radii");
    let share = |status: &str| counts.get(status).copied().unwrap_or(0) as f64 / pairs.len() as f64;
    assert!(share("separated") > 0.2 && share("overlapping") > 0.2, "{counts:?}");
    assert!((open as f64) < 0.3 * pairs.len() as f64, "{counts:?}");
}

/// Depths against all facets of the Minkowski difference, of hulls that have few enough.
#[test]
fn intervals_hold_the_depth() {
    for device in scene::devices() {
        hold_the_depth(&device);
    }
}

fn hold_the_depth(device: &Device) {
    let pack = scene::small_pack();
    let mut pairs = scene::pairs(&pack, scene::pair_count(4_000) / 4, 13);
    let touching = scene::touching_pairs(&pack, pairs.len() / 4, 19);
    pairs.extend(touching);
    let polytopes: Vec<_> = (0..pack.hull_count()).map(|at| Polytope::new(&pack.hull(at).unwrap())).collect();
    let mut batch = Batch::on(device, &pack).unwrap();
    let answers = solve(&mut batch, Query::Contact, &pairs);
    let mut widest = 0.0_f64;
    for (at, (pair, answer)) in pairs.iter().zip(answers).enumerate() {
        let (a, b) = (&polytopes[pair.a as usize], polytopes[pair.b as usize].placed(pair.b_in_a));
        let (signed, _) = signed_depth(a, &b, f64::NEG_INFINITY);
        let slack = rounding_error(a, &b, 1.0);
        let depth = signed.max(0.0);
        let holds = answer.lower <= depth + slack && depth - slack <= answer.upper;
        assert!(holds, "pair {at}, seed 13: {answer:?} of {signed}");
        match answer.status {
            Status::Separated => assert!(signed <= slack, "pair {at}: separated, but {signed}"),
            Status::Overlapping | Status::Stalled => assert!(signed >= -slack, "pair {at}: overlaps, but {signed}"),
            _ => {}
        }
        if answer.status == Status::Overlapping {
            widest = widest.max((answer.upper - answer.lower) / a.greatest());
            let along = answer.point_a - answer.point_b;
            assert!(
                along.length() <= answer.upper + 1e-4 * a.greatest() && answer.normal.is_normalized(),
                "{answer:?}"
            );
        }
    }
    let counts = counts(answers);
    println!("{counts:?}; the widest interval within the tolerance is {widest:.2e} of the hulls");
    assert!(counts["separated"] > pairs.len() / 5 && counts["overlapping"] > pairs.len() / 3, "{counts:?}");
}

#[test]
fn the_processor_agrees_and_settles_the_rest_bit_for_bit() {
    let Some(device) = scene::device() else { return };
    let pack = scene::pack(IndexKind::Tree);
    let pairs = scene::pairs(&pack, scene::pair_count(4_000), 3);
    let settings = Settings { tolerance: f64::from(TOLERANCE), ..Settings::default() };
    let mut on_gpu = Batch::on(&device, &pack).unwrap();
    let mut on_cpu = Batch::new(&pack, Backend::Cpu).unwrap();
    for query in [Query::Distance, Query::Contact] {
        let expected = solve(&mut on_cpu, query, &pairs).to_vec();
        let before = solve(&mut on_gpu, query, &pairs).to_vec();
        let settled = on_gpu.settle();
        assert_eq!(settled, before.iter().filter(|answer| answer.status.is_unsettled()).count());
        assert!(settled > 0);
        for (at, pair) in pairs.iter().enumerate() {
            let (before, after, expected) = (&before[at], &on_gpu.answers()[at], &expected[at]);
            let context = || format!("{query:?}, pair {at}: {before:?}, {expected:?}");
            if !before.status.is_unsettled() {
                let apart = if query == Query::Distance { expected.upper > 0.0 } else { expected.lower == 0.0 };
                let proven =
                    if before.status == Status::Separated { apart } else { expected.status != Status::Separated };
                assert!(proven && !contradict(query, [before.status, expected.status]), "{}", context());
                continue;
            }
            assert_eq!(after, expected, "{}", context());
            let (a, b) = (pack.hull(pair.a as usize).unwrap(), pack.hull(pair.b as usize).unwrap());
            let own = match query {
                Query::Contact => {
                    let own = hullmap::contact(&a, &b, pair.b_in_a, &settings, &mut Cache::new());
                    (own.depth_lower, own.point_a)
                }
                _ => {
                    let own = hullmap::distance(&a, &b, pair.b_in_a, &settings, &mut Cache::new());
                    (own.lower, own.point_a)
                }
            };
            assert_eq!((after.lower.to_bits(), after.point_a), (own.0.to_bits(), own.1));
        }
    }
}

#[test]
fn permuted_pairs_have_permuted_answers() {
    let Some(device) = scene::device() else { return };
    let pack = scene::pack(IndexKind::Tree);
    let mut pairs = scene::pairs(&pack, 1_000, 4);
    let mut batch = Batch::on(&device, &pack).unwrap();
    let mut rng = SplitMix64::new(5);
    for query in QUERIES {
        solve(&mut batch, query, &pairs);
        let mut expected: Vec<_> = batch.records().1.iter().map(AnswerRecord::bits).collect();
        for last in (1..pairs.len()).rev() {
            let other = rng.below(last + 1);
            pairs.swap(last, other);
            expected.swap(last, other);
        }
        solve(&mut batch, query, &pairs);
        assert!(batch.records().1.iter().map(AnswerRecord::bits).eq(expected), "{query:?}");
    }
    // A shorter batch in the same buffers.
    solve(&mut batch, Query::Distance, &pairs[..7]);
    assert!(batch.answers().len() == 7);
    assert!(solve(&mut batch, Query::Distance, &[]).is_empty());
}

/// A scan in f64, in random directions, along axes and seams, and along normals of faces, where the
/// planes and fans of an index meet.
#[test]
fn support_vertices_fall_short_by_rounding_error_only() {
    let Some(device) = scene::device() else { return };
    for index in ALL_INDICES {
        let pack = scene::pack(index);
        let mut batch = Batch::on(&device, &pack).unwrap();
        let mut rng = SplitMix64::new(7);
        let mut queries = Vec::new();
        for (at, hull) in (0..pack.hull_count()).map(|at| (at as u32, pack.hull(at).unwrap())) {
            let mut ask = |dir: DVec3| queries.push(SupportQuery { hull: at, dir: dir.as_vec3() });
            for _ in 0..200 {
                let dir = rng.unit_vector();
                ask(dir * 10_f64.powf(rng.between(-6.0, 6.0)));
                ask(dir.signum() + dir * 1e-7);
            }
            for axis in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(1.0, 1.0, 0.0), DVec3::ONE] {
                ask(axis);
                ask(-axis);
            }
            for normal in (0..hull.face_count().min(300)).filter_map(|face| hull.face_normal(face as u32)) {
                ask(normal);
                for size in [1e-7, 1e-6, 1e-5, 1e-4] {
                    ask(normal + rng.unit_vector() * size);
                }
            }
        }
        let found = batch.support(&queries).unwrap();
        let mut worst = 0.0_f64;
        for (query, found) in queries.iter().zip(found) {
            let hull = pack.hull(query.hull as usize).unwrap();
            let dir = query.dir.as_dvec3();
            let best = hull.vertices().map(|v| v.as_dvec3().dot(dir)).fold(f64::NEG_INFINITY, f64::max);
            let regret = (best - found.point.as_dvec3().dot(dir)) / (dir.length() * hull.outer_radius().max(1e-30));
            assert!(found.is_certain && regret <= SUPPORT_SHORTFALL, "{index:?}: {query:?} {found:?} {regret:e}");
            worst = worst.max(regret);
        }
        println!("{index:?}: {} directions, greatest regret {worst:.2e} of the radius", queries.len());
        for dir in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY] {
            assert!(!batch.support(&[SupportQuery { hull: 0, dir }]).unwrap()[0].is_certain);
        }
        assert!(!batch.support(&[SupportQuery { hull: 99, dir: Vec3::X }]).unwrap()[0].is_certain);
    }
}

#[test]
fn damaged_packs_neither_hang_nor_read_outside() {
    let Some(device) = scene::device() else { return };
    let mut rng = SplitMix64::new(8);
    let mut opened = 0;
    for index in [IndexKind::Tree, IndexKind::Binary, IndexKind::CubeMap { resolution: 24 }] {
        let whole = scene::pack(index);
        let pairs = scene::pairs(&whole, 256, 9);
        let queries: Vec<_> =
            (0..256).map(|at| SupportQuery { hull: at % 13, dir: rng.unit_vector().as_vec3() }).collect();
        for round in 0..20 {
            let mut file = whole.bytes().to_vec();
            for _ in 0..1 << (round % 12) {
                let at = 64 + rng.below(file.len() - 64 - 144);
                file[at] ^= 1 << rng.below(8);
            }
            reseal(&mut file);
            let Ok(pack) = Pack::from_bytes_skipping_contents(&file) else { continue };
            opened += 1;
            let mut batch = Batch::on(&device, &pack).unwrap();
            for query in [Query::Distance, Query::Contact] {
                solve(&mut batch, query, &pairs);
            }
            batch.support(&queries).unwrap();
        }
    }
    assert!(opened > 10, "{opened} packs opened");
}

#[test]
fn hulls_of_several_packs_answer_as_in_one_pack() {
    let Some(device) = scene::device() else { return };
    let (first, second) = (scene::pack(IndexKind::Tree), scene::small_pack());
    let count = first.hull_count() as u32;
    let mut batch = Batch::of_packs(&device, &[&first, &second]).unwrap();
    let mut alone = Batch::on(&device, &second).unwrap();
    let pairs = scene::pairs(&second, 500, 23);
    let moved: Vec<IndexedPair> =
        pairs.iter().map(|pair| IndexedPair { a: pair.a + count, b: pair.b + count, ..*pair }).collect();
    for query in QUERIES {
        let expected = solve(&mut alone, query, &pairs).to_vec();
        assert_eq!(solve(&mut batch, query, &moved), expected);
        batch.settle();
        alone.settle();
        assert_eq!(batch.answers(), alone.answers());
    }
    let ask = |hull| SupportQuery { hull, dir: Vec3::new(1.0, 2.0, -1.0) };
    for hull in 0..second.hull_count() as u32 {
        let expected = alone.support(&[ask(hull)]).unwrap()[0];
        assert_eq!(batch.support(&[ask(count + hull)]).unwrap()[0], expected);
    }
    assert!(!batch.support(&[ask(count + 99)]).unwrap()[0].is_certain);
    // Across packs, against the processor.
    let across: Vec<IndexedPair> =
        pairs.iter().map(|pair| IndexedPair { a: pair.a, b: pair.b + count, ..*pair }).collect();
    for (pair, found) in across.iter().zip(solve(&mut batch, Query::Distance, &across)) {
        let (a, b) = (first.hull(pair.a as usize).unwrap(), second.hull((pair.b - count) as usize).unwrap());
        let own = hullmap::distance(&a, &b, pair.b_in_a, &Settings::default(), &mut Cache::new());
        assert!(found.lower <= own.upper && own.lower <= found.upper, "{found:?}, {own:?}");
    }
}

#[test]
fn pairs_of_no_hull_are_rejected_alone() {
    let Some(device) = scene::device() else { return };
    let pack = scene::pack(IndexKind::Tree);
    let mut batch = Batch::on(&device, &pack).unwrap();
    let mut pairs = scene::pairs(&pack, 3, 10);
    pairs[1].b = 1_000;
    let answers = solve(&mut batch, Query::Distance, &pairs);
    assert!(answers[1].status == Status::Rejected && answers[1].upper == f64::INFINITY && answers[1].lower == 0.0);
    assert!(answers[0].status != Status::Rejected && answers[2].status != Status::Rejected);
}

#[test]
fn a_few_steps_end_with_a_valid_interval() {
    let Some(device) = scene::device() else { return };
    let pack = scene::pack(IndexKind::Tree);
    let pairs = scene::pairs(&pack, 500, 11);
    let mut batch = Batch::on(&device, &pack).unwrap();
    let whole = solve(&mut batch, Query::Distance, &pairs).to_vec();
    for max_iterations in [0, 1, 2, 4] {
        let few = batch.distance(&pairs, &Settings { max_iterations, ..Settings::default() }).unwrap();
        assert!(few.iter().any(|answer| answer.status == Status::Budget));
        for (few, whole) in few.iter().zip(&whole) {
            assert!(few.steps <= max_iterations && few.lower <= whole.upper && whole.lower <= few.upper);
        }
    }
}

#[test]
fn a_lost_device_is_an_error_and_the_processor_takes_over() {
    let Some(device) = scene::device() else { return };
    let pack = scene::pack(IndexKind::Tree);
    let pairs = scene::pairs(&pack, 50, 12);
    let mut batch = Batch::on(&device, &pack).unwrap();
    device.destroy();
    let error = batch.distance(&pairs, &Settings::default()).unwrap_err();
    assert!(matches!(error, Error::Device { .. }), "{error}");
    assert!(batch.answers().is_empty());
    batch.use_processor();
    assert_eq!(batch.distance(&pairs, &Settings::default()).unwrap().len(), 50);
}
