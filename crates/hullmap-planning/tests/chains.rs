//! Queries of robots: a chain with a formula, and random chains, checked by samples.

mod described;

use std::f64::consts::PI;

use described::{file, robot};
use hullmap::shapes::{HalfSpace, Sphere};
use hullmap::{Differentiability, Pose, Settings, SharedGeometry, Status, Verdict};
use hullmap_planning::glam::DVec3;
use hullmap_planning::{EdgeSettings, Obstacle, PlanningError, Robot};
use hullmap_random::SplitMix64;
use hullmap_robot::{Description, Displacement, Places};

/// Two links of length 1 in a plane, with balls of radius 0.1 at the base and of 0.2 at the tip.
/// Their centres are 2 |cos(b/2)| apart, for the angle b of the elbow.
fn balls() -> Robot {
    robot(
        "balls.xml",
        "<mujoco><compiler angle='radian'/><worldbody><body name='base'>
          <geom type='sphere' size='0.1'/>
          <body name='upper'><joint name='a' axis='0 0 1'/>
            <body name='lower' pos='1 0 0'><joint name='b' axis='0 0 1' range='-3.1 3.1'/>
              <geom type='sphere' size='0.2' pos='1 0 0'/></body></body></body></worldbody></mujoco>",
    )
}

#[test]
fn two_balls_have_the_clearance_and_the_gradient_of_the_formula() {
    let arm = balls();
    assert_eq!(arm.joints().iter().map(|joint| joint.name.as_str()).collect::<Vec<_>>(), ["a", "b"]);
    assert_eq!((arm.joints()[0].limits, arm.joints()[1].limits), (None, Some([-3.1, 3.1])));
    let (mut memory, mut gradient) = (arm.memory(), [0.0; 2]);
    for (a, b) in [(0.0, 0.5), (1.3, -2.0), (-7.0, 2.9), (0.4, 3.0), (2.0, -3.05)] {
        let (found, status) =
            arm.clearance_gradient(&[a, b], &Settings::default(), &mut memory, &mut gradient).unwrap();
        let truth = 2.0 * (b / 2.0).cos().abs() - 0.3;
        assert!(found.lower <= truth && truth <= found.upper && found.upper - found.lower < 1e-5, "{b}: {found:?}");
        assert_eq!(status, Differentiability::Unique);
        assert!(gradient[0].abs() < 1e-9 && (gradient[1] + (b / 2.0).sin()).abs() < 1e-6, "{gradient:?}");
        let names = found.colliders.unwrap().map(|index| arm.collider(index).unwrap());
        assert_eq!(names, ["base", "lower"]);
        assert_eq!(arm.in_collision(&[a, b], 0.0, &mut memory).unwrap(), truth < 0.0);
        assert!(arm.in_collision(&[a, b], truth + 1e-3, &mut memory).unwrap());
        assert!(!arm.in_collision(&[a, b], (truth - 1e-3).max(0.0), &mut memory).unwrap() || truth < 1e-3);
    }
}

#[test]
fn an_edge_of_two_balls_hits_when_the_formula_says() {
    let arm = balls();
    let mut memory = arm.memory();
    let end = 3.0;
    let settings = EdgeSettings { resolution: 1e-9, ..EdgeSettings::default() };
    // 2 cos(b/2) = 0.3 + margin.
    for margin in [0.0_f64, 0.1] {
        let truth = 2.0 * (0.15 + margin / 2.0).acos();
        for a in [0.0, 20.0] {
            let own = EdgeSettings { margin, ..settings };
            let found = arm.clear(&[0.0, 0.0], &[a, end], &own, &mut memory).unwrap();
            assert_eq!(found.answer.verdict, Verdict::Hit);
            let (lower, upper) = (found.answer.t_lower * end, found.answer.t_upper * end);
            assert!(lower <= truth && truth <= upper && upper - lower < 1e-8, "{truth}: {found:?}");
        }
    }
    // Up to just before, it is free; and the least distance is at the end.
    let found = arm.clear(&[0.0, 0.0], &[9.0, 2.8], &settings, &mut memory).unwrap();
    let truth = 2.0 * 1.4_f64.cos() - 0.3;
    assert_eq!(found.answer.verdict, Verdict::Free);
    assert!(0.5 * truth <= found.answer.clearance * 1.01 && found.answer.clearance <= truth, "{found:?}");
    // An edge that grazes is open or a hit, and never free.
    let touching = 2.0 * 0.15_f64.acos();
    let found = arm.clear(&[0.0, 0.0], &[0.0, touching], &settings, &mut memory).unwrap();
    assert!(found.answer.verdict != Verdict::Free && (found.answer.t_lower - 1.0).abs() < 1e-6, "{found:?}");
}

#[test]
fn budgets_end_in_open_edges() {
    let arm = balls();
    let (settings, mut memory) = (EdgeSettings { max_queries: 3, ..EdgeSettings::default() }, arm.memory());
    let found = arm.clear(&[0.0, -2.8], &[0.0, 2.8], &settings, &mut memory).unwrap();
    assert!(found.answer.iterations <= 3);
    assert!(found.answer.verdict != Verdict::Hit && found.answer.status == Status::IterationLimit, "{found:?}");
}

/// A distance with a tolerance is undecided near the margin: a slow approach to it had an interval
/// of many resolutions.
#[test]
fn the_interval_of_a_hit_is_as_narrow_as_the_resolution() {
    let mut random = SplitMix64::new(44);
    let mut hits = 0;
    for _ in 0..30 {
        let turned: Vec<String> = (0..4).map(|_| format!("{:.4}", random.between(-1.0, 1.0))).collect();
        let arm = robot(
            "slow.xml",
            &format!(
                "<mujoco><worldbody><body name='base'><geom type='ellipsoid' size='0.3 0.2 0.1'/><body name='mid'><joint name='still' axis='1 0 0'/>
                 <body name='tip' pos='1 0 0'><joint name='a' type='slide' axis='-1 0 0'/>
                 <geom type='cylinder' size='0.2 0.1' quat='{}'/></body></body></body></worldbody></mujoco>",
                turned.join(" ")
            ),
        );
        let memory = &mut arm.memory();
        let settings = EdgeSettings { margin: 0.02, ..EdgeSettings::default() };
        // Where the margin is crossed.
        let (mut before, mut after) = (0.0, 1.0);
        for _ in 0..40 {
            let middle = 0.5 * (before + after);
            let gap = arm.clearance(&[0.0, middle], &Settings::default(), memory).unwrap().upper;
            *if gap > settings.margin { &mut before } else { &mut after } = middle;
        }
        for step in [1e-3, 5e-3] {
            let from = before - 0.3 * step;
            let found = arm.clear(&[0.0, from], &[0.0, from + step], &settings, memory).unwrap().answer;
            hits += usize::from(found.verdict == Verdict::Hit);
            assert!(found.verdict != Verdict::Hit || found.status == Status::Within, "{found:?}");
            assert!(found.verdict != Verdict::Hit || found.t_upper - found.t_lower <= 1e-3, "{found:?}");
            // Rounding error forbids more than this.
            let fine = EdgeSettings { resolution: 0.0, ..settings };
            let found = arm.clear(&[0.0, from], &[0.0, from + step], &fine, memory).unwrap().answer;
            assert!(found.status != Status::Within || found.t_upper <= found.t_lower, "{found:?}");
        }
    }
    assert!(hits > 40, "{hits}");
}

#[test]
fn obstacles_are_tested_unless_they_are_allowed() {
    let mut arm = balls();
    let at = |x, y| Pose::from_translation(DVec3::new(x, y, 0.0)).unwrap();
    let ball = SharedGeometry::from_shape(Sphere::new(0.5).unwrap());
    let wall = SharedGeometry::HalfSpace(HalfSpace::new(DVec3::X, -1.5).unwrap());
    let obstacle =
        |name: &str, shape: &SharedGeometry, pose| Obstacle { name: name.to_owned(), shape: shape.clone(), pose };
    arm.add_obstacles([obstacle("ball", &ball, at(2.0, 1.0)), obstacle("wall", &wall, at(0.0, 0.0))]).unwrap();
    let again = arm.add_obstacles([obstacle("ball", &ball, at(9.0, 0.0))]).unwrap_err();
    assert!(matches!(again, PlanningError::NameInUse { .. }), "{again}");
    let (mut memory, mut gradient) = (arm.memory(), [0.0; 2]);
    // The tip is at (2, 0): 0.3 from the ball.
    let (found, _) = arm.clearance_gradient(&[0.0, 0.0], &Settings::default(), &mut memory, &mut gradient).unwrap();
    assert!((found.upper - 0.3).abs() < 1e-9 && found.normal.distance(DVec3::Y) < 1e-6, "{found:?}");
    assert!((gradient[0] + 2.0).abs() < 1e-6 && (gradient[1] + 1.0).abs() < 1e-6, "{gradient:?}");
    assert_eq!(found.colliders.map(|[_, other]| arm.collider(other).unwrap()), Some("ball"));
    // Stretched to the other side, the tip is at x = -2, and 0.7 deep in the wall.
    let (found, status) =
        arm.clearance_gradient(&[2.5, 0.0], &Settings::default(), &mut memory, &mut gradient).unwrap();
    let truth = 2.0 * 2.5_f64.cos() + 1.5 - 0.2;
    assert!(found.lower <= truth && truth <= found.upper && found.upper - found.lower < 1e-9, "{truth} {found:?}");
    assert_eq!(status, Differentiability::Unique);
    assert!((gradient[0] + 2.0 * 2.5_f64.sin()).abs() < 1e-9, "{gradient:?}");
    let edge = EdgeSettings { resolution: 1e-9, ..EdgeSettings::default() };
    let found = arm.clear(&[0.0, 0.0], &[-PI, 0.0], &edge, &mut memory).unwrap();
    // The tip reaches the wall at x = -1.3.
    let truth = (-0.65_f64).acos() / PI;
    assert!(found.answer.t_lower <= truth && truth <= found.answer.t_upper, "{truth} {found:?}");
    assert!(found.answer.t_upper - found.answer.t_lower < 1e-8);
    arm.allow([["wall", "lower"]]).unwrap();
    let mut memory = arm.memory();
    assert!(!arm.in_collision(&[2.5, 0.0], 0.0, &mut memory).unwrap());
    let wrong = arm.allow([["wall", "hand"]]).unwrap_err();
    assert!(wrong.to_string().contains("`hand` is neither a link"), "{wrong}");
}

#[test]
fn wrong_configurations_are_errors() {
    let arm = balls();
    let mut memory = arm.memory();
    let error = arm.in_collision(&[0.0], 0.0, &mut memory).unwrap_err();
    assert_eq!(error.to_string(), "a configuration has 2 numbers, one for each joint, found 1");
    for wrong in [f64::NAN, f64::INFINITY, 1e300] {
        let error = arm.clear(&[0.0, 0.0], &[0.0, wrong], &EdgeSettings::default(), &mut memory).unwrap_err();
        assert!(error.to_string().starts_with("joint `b`: "), "{error}");
    }
    assert!(arm.in_collision_at(&[Pose::IDENTITY], 0.0, &mut memory).is_err());
}

/// A random tree of links, with hinges, sliders, two joints on a link, and following joints.
fn random_text(random: &mut SplitMix64) -> String {
    let mut number = |low: f64, high: f64| format!("{:.4}", random.between(low, high));
    let count = 5;
    let (mut open, mut close) = (String::new(), String::new());
    for link in 0..count {
        let places: Vec<String> = (0..3).map(|_| number(-0.4, 0.4)).collect();
        let axis: Vec<String> = (0..3).map(|_| number(-1.0, 1.0)).collect();
        let turned: Vec<String> = (0..4).map(|_| number(-1.0, 1.0)).collect();
        open += &format!("<body name='l{link}' pos='{}' quat='{}'>", places.join(" "), turned.join(" "));
        let kind = if link == 2 { "slide" } else { "hinge" };
        open +=
            &format!("<joint name='j{link}' type='{kind}' axis='{}' pos='{} 0 0'/>", axis.join(" "), number(-0.2, 0.2));
        if link == 3 {
            open += "<joint name='second' type='hinge' axis='0 1 0' ref='0.3'/>";
        }
        let sizes: Vec<String> = (0..3).map(|_| number(0.03, 0.15)).collect();
        let shape = ["box", "capsule", "ellipsoid", "cylinder", "sphere"][link % 5];
        open += &format!("<geom type='{shape}' size='{}' pos='0.1 {} 0'/>", sizes.join(" "), number(-0.1, 0.1));
        close += "</body>";
    }
    format!(
        "<mujoco><compiler angle='radian'/><worldbody><geom type='box' size='0.2 0.2 0.05' pos='0 0 -0.5'/>{open}{close}\
         </worldbody><equality><joint joint1='j4' joint2='j1' polycoef='0.1 0.8 -0.3 0.1 0'/></equality></mujoco>"
    )
}

#[test]
fn forward_kinematics_are_those_of_the_chain() {
    let mut random = SplitMix64::new(7);
    for _ in 0..20 {
        let (_guard, path) = file("r.xml", &random_text(&mut random));
        let description = Description::read(&path, &Places::default()).unwrap();
        let own = Robot::new(&description, |_| unreachable!()).unwrap();
        let q: Vec<f64> = own.joints().iter().map(|_| random.between(-2.0, 2.0)).collect();
        let mut displacements = description.chain.neutral();
        let free = description.chain.joints.iter().enumerate().filter(|(_, joint)| joint.coupling.is_none());
        for ((at, joint), value) in free.zip(&q) {
            displacements[at] = Displacement::Scalar(value - joint.reference);
        }
        description.chain.follow(&mut displacements);
        let frames = description.chain.poses(&displacements);
        let poses: Vec<Pose> =
            frames.iter().map(|frame| Pose::new(frame.translation, frame.rotation).unwrap()).collect();
        let (mut memory, settings) = (own.memory(), Settings::default());
        let here = own.clearance(&q, &settings, &mut memory).unwrap();
        let there = own.clearance_at(&poses, &settings, &mut memory).unwrap();
        assert!((here.upper - there.upper).abs() < 1e-9 && here.colliders == there.colliders, "{here:?} {there:?}");
    }
}

/// Edges of random robots, checked by samples of the clearance, which is certified.
#[test]
fn samples_never_contradict_an_edge() {
    let seed = 40;
    println!("seed {seed}");
    let mut random = SplitMix64::new(seed);
    let samples = 1000;
    let (mut free, mut hit, mut open) = (0, 0, 0);
    for _ in 0..12 {
        let arm = robot("r.xml", &random_text(&mut random));
        let mut memory = arm.memory();
        for case in 0..12 {
            let length = [0.1, 1.0, 4.0][case % 3];
            let start: Vec<f64> = arm.joints().iter().map(|_| random.between(-2.0, 2.0)).collect();
            let end: Vec<f64> = start.iter().map(|value| value + random.between(-length, length)).collect();
            let settings = EdgeSettings { margin: if case % 4 == 3 { 0.02 } else { 0.0 }, ..EdgeSettings::default() };
            let found = arm.clear(&start, &end, &settings, &mut memory).unwrap().answer;
            let (mut first, mut least) = (f64::INFINITY, f64::INFINITY);
            for sample in 0..=samples {
                let t = f64::from(sample) / f64::from(samples);
                let q: Vec<f64> = start.iter().zip(&end).map(|(start, end)| start + (end - start) * t).collect();
                let at = arm.clearance(&q, &Settings::default(), &mut memory).unwrap();
                least = least.min(at.upper);
                if at.upper < settings.margin && first == f64::INFINITY {
                    first = t;
                }
            }
            match found.verdict {
                Verdict::Free => {
                    free += 1;
                    assert!(first == f64::INFINITY && found.clearance <= least, "{found:?} {first} {least}");
                    assert!(found.clearance > settings.margin);
                    assert!(found.status != Status::Within || found.clearance >= 0.5 * found.nearest, "{found:?}");
                }
                Verdict::Hit => {
                    hit += 1;
                    let step = 1.0 / f64::from(samples);
                    assert!(found.t_lower <= first && first < found.t_upper + step || first == f64::INFINITY);
                    assert!(first < f64::INFINITY || least < settings.margin + 0.01, "{found:?} {least}");
                    assert!(found.t_upper - found.t_lower <= settings.resolution, "{found:?}");
                    assert_eq!(found.status, Status::Within, "{found:?}");
                }
                Verdict::Open => {
                    open += 1;
                    assert!(found.t_lower <= first, "{found:?} {first}");
                }
            }
        }
    }
    println!("{free} free, {hit} hit, {open} open");
    assert!(free >= 20 && hit >= 40 && open <= 3, "{free} free, {hit} hit, {open} open");
}

#[test]
fn gradients_agree_with_central_differences() {
    let seed = 41;
    println!("seed {seed}");
    let mut random = SplitMix64::new(seed);
    let settings = Settings { tolerance: 0.0, ..Settings::default() };
    let (mut unique, mut wrong, mut overlapping) = (0, 0, 0);
    for _ in 0..10 {
        let arm = robot("r.xml", &random_text(&mut random));
        let mut memory = arm.memory();
        for _ in 0..40 {
            let q: Vec<f64> = arm.joints().iter().map(|_| random.between(-2.0, 2.0)).collect();
            let mut gradient = vec![0.0; q.len()];
            // The gradient is exact, whatever the tolerance.
            let rough = Settings { tolerance: 1e-4, ..settings };
            let (found, status) = arm.clearance_gradient(&q, &rough, &mut memory, &mut gradient).unwrap();
            if status != Differentiability::Unique {
                continue;
            }
            unique += 1;
            overlapping += usize::from(found.upper < 0.0);
            let mut value = |at: usize, step: f64| {
                let mut q = q.clone();
                q[at] += step;
                let found = arm.clearance(&q, &settings, &mut memory).unwrap();
                0.5 * (found.lower + found.upper)
            };
            let step = 1e-5;
            let is_wrong = |at: usize, value: &mut dyn FnMut(usize, f64) -> f64| {
                let difference = (value(at, step) - value(at, -step)) / (2.0 * step);
                (difference - gradient[at]).abs() > 1e-6
            };
            wrong += usize::from((0..q.len()).any(|at| is_wrong(at, &mut value)));
        }
    }
    println!("{unique} unique, {overlapping} of them overlap, {wrong} differ");
    // A difference across a change of the pair or of the feature differs.
    assert!(unique >= 200 && overlapping >= 20 && wrong * 100 <= unique, "{unique} {overlapping} {wrong}");
}

#[test]
fn batches_have_the_answers_of_single_queries() {
    let mut random = SplitMix64::new(3);
    let arm = robot("r.xml", &random_text(&mut random));
    let width = arm.joint_count();
    let q: Vec<f64> = (0..600 * width).map(|_| random.between(-2.0, 2.0)).collect();
    let (mut hits, mut gaps) = (vec![false; 600], vec![Default::default(); 600]);
    arm.in_collision_batch(&q, 0.0, &mut hits).unwrap();
    arm.clearance_batch(&q, &Settings::default(), &mut gaps).unwrap();
    let count = hits.iter().filter(|hit| **hit).count();
    assert!((30..500).contains(&count), "{count}");
    for (row, (hit, gap)) in q.chunks(width).zip(hits.iter().zip(&gaps)) {
        assert_eq!(arm.in_collision(row, 0.0, &mut arm.memory()).unwrap(), *hit);
        assert_eq!(gap.upper < 0.0 || gap.lower <= 0.0, *hit);
    }
    let (start, end) = q.split_at(300 * width);
    let mut edges = vec![Default::default(); 300];
    arm.clear_batch(start, end, &EdgeSettings::default(), &mut edges).unwrap();
    let mut again = edges.clone();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    pool.install(|| arm.clear_batch(start, end, &EdgeSettings::default(), &mut again)).unwrap();
    assert_eq!(edges, again);
    assert!(arm.in_collision_batch(&q[1..], 0.0, &mut hits).is_err());
}

/// Separated parts of an obstacle once counted as a contact of unknown depth.
#[test]
fn parts_that_are_apart_have_no_depth() {
    let mut arm = balls();
    let corner =
        |at: usize, x: f32| [(at & 1) as f32 * 0.2 + x, (at >> 1 & 1) as f32 * 0.2 + 0.5, (at >> 2) as f32 * 0.2];
    let cube = |x: f32| {
        let positions = (0..8).map(|at| corner(at, x)).collect();
        let points = hullmap_bake::PointSet { positions, source_vertices: (0..8).collect(), ..Default::default() };
        hullmap_bake::bake_hull(&points, hullmap_bake::IndexKind::Tree).unwrap()
    };
    let bytes = hullmap_bake::write_pack(&[cube(0.0), cube(3.0)], &Default::default()).unwrap();
    let shape = SharedGeometry::Compound(std::sync::Arc::new(hullmap::Pack::from_bytes(&bytes).unwrap()));
    arm.add_obstacles([Obstacle { name: "cubes".to_owned(), shape, pose: Pose::IDENTITY }]).unwrap();
    // The balls at base and tip overlap, and the tip is inside of the box around the cubes.
    let found = arm.clearance(&[0.0, 3.1], &Settings::default(), &mut arm.memory()).unwrap();
    let truth = 2.0 * 1.55_f64.cos() - 0.3;
    assert!(found.lower <= truth && truth <= found.upper && found.upper - found.lower < 1e-4, "{truth} {found:?}");
}
