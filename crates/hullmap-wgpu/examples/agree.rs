//! Compares the decisions of the processor's batch with the GPU's, on random pairs of many
//! different hulls. Exits with 1 if they contradict each other.
//!
//!     cargo run --release --example agree -- --pairs 10000000 --seed 1
//!
//! The hulls have 8 to 65,536 vertices, in equal ratios. They are in packs of 50, each with all
//! sizes. One pair in four has parallel axes. One in eight only just touches: it is moved by the
//! distance of its hulls, and up to 1e-4 of their radii more or less.
//!
//! `--first-pack N` continues a run that ended before the pack with index N, counted from 1.

use std::time::Instant;

use hullmap::glam::{DQuat, DVec3};
use hullmap::{Cache, Hull, Pack, Pose, Settings, SupportMap};
use hullmap_bake::IndexKind;
use hullmap_testkit::{packs, random::RandomPoses};
use hullmap_wgpu::{Answer, Backend, Batch, Device, IndexedPair, Query, Status};
use shapes::{families, rng::SplitMix64};

/// Numbers of vertices of the smallest and the largest hull.
const SIZES: [f64; 2] = [8.0, 65_536.0];

/// Hulls of a pack. All sections of a pack must fit into one binding.
const HULLS_OF_A_PACK: usize = 50;

/// Pairs that both sides solve before they are compared.
const BLOCK: usize = 1 << 16;

type Family = fn(usize, u64) -> Vec<[f32; 3]>;

/// Shapes of which every point is a vertex, or nearly so.
const FAMILIES: [Family; 6] = [
    families::sphere,
    families::clustered_ellipsoid,
    families::rotated_prism,
    families::cone,
    families::lens,
    families::uv_sphere,
];

/// The arguments: `--name N`.
struct Arguments {
    pairs: usize,
    seed: u64,
    hulls: usize,
    query: Query,
    first_pack: usize,
}

#[expect(clippy::disallowed_methods, reason = "a program has arguments")]
fn arguments() -> Result<Arguments, String> {
    let mut found = Arguments { pairs: 100_000, seed: 1, hulls: 1_000, query: Query::Intersects, first_pack: 1 };
    let mut words = std::env::args().skip(1);
    while let Some(name) = words.next() {
        let value = words.next().ok_or_else(|| format!("{name} requires a value"))?;
        let number = || value.parse::<u64>().map_err(|error| format!("{name} {value}: {error}"));
        match name.as_str() {
            "--pairs" => found.pairs = number()? as usize,
            "--seed" => found.seed = number()?,
            "--hulls" => found.hulls = number()? as usize,
            "--first-pack" => found.first_pack = number()?.max(1) as usize,
            "--query" => {
                found.query = match value.as_str() {
                    "intersects" => Query::Intersects,
                    "distance" => Query::Distance,
                    "contact" => Query::Contact,
                    _ => return Err(format!("--query {value}: expected intersects, distance or contact")),
                }
            }
            _ => {
                let known = "--pairs, --seed, --hulls, --query or --first-pack";
                return Err(format!("unknown option {name}: expected {known}"));
            }
        }
    }
    Ok(found)
}

/// The pack with index `at` of `count`.
fn bake(at: usize, count: usize, hulls: usize, seed: u64) -> Pack {
    let set = |index: usize| {
        let share = index as f64 / (hulls - 1).max(1) as f64;
        let size = (SIZES[0] * (SIZES[1] / SIZES[0]).powf(share)).round() as usize;
        let positions = FAMILIES[index / count % FAMILIES.len()](size, seed.wrapping_mul(1_000_003) + index as u64);
        packs::point_set("hull", &positions)
    };
    let sets: Vec<_> = (at..hulls).step_by(count).map(set).collect();
    let bytes = packs::bytes(&sets, IndexKind::Tree, &Default::default()).expect("the families can be baked");
    Pack::from_bytes(&bytes).expect("a baked pack opens")
}

fn random_pair(hulls: &[Hull<'_>], at: usize, rng: &mut SplitMix64) -> IndexedPair {
    let (a, b) = (rng.below(hulls.len()), rng.below(hulls.len()));
    let rotation = if at.is_multiple_of(4) { DQuat::IDENTITY } else { rng.rotation() };
    let reach = hulls[a].outer_radius() + hulls[b].outer_radius();
    let apart = rng.unit_vector() * rng.between(0.0, 1.1 * reach);
    let mut translation = hulls[a].interior_point() + apart - rotation * hulls[b].interior_point();
    let posed = |translation: DVec3| Pose::new(translation, rotation).expect("finite");
    if at % 8 == 1 {
        let (settings, mut cache) = (Settings::default(), Cache::new());
        let found = hullmap::distance(&hulls[a], &hulls[b], posed(translation), &settings, &mut cache);
        let more = [0.0, 1e-8, -1e-8, 1e-7, -1e-7, 1e-6, -1e-6, 1e-5, -1e-5, 1e-4, -1e-4][rng.below(11)];
        if found.lower > 0.0 {
            translation -= found.normal * (found.lower + more * reach);
        }
    }
    IndexedPair { a: a as u32, b: b as u32, b_in_a: posed(translation) }
}

#[derive(Default)]
struct Tally {
    separated: usize,
    overlapping: usize,
    /// The interval of the GPU or of the processor holds 0.
    open_on_gpu: usize,
    open_on_processor: usize,
    /// Proven on the GPU, but not within the tolerance.
    stalled: usize,
    /// Intervals that do not meet, and contradictions.
    wrong: usize,
    seconds: [f64; 2],
}

/// Whether the answer proves an overlap, or a separation, or nothing.
fn proof(answer: &Answer, query: Query) -> Option<bool> {
    match answer.status {
        Status::Overlapping => Some(true),
        Status::Separated => Some(false),
        Status::Stalled => Some(query == Query::Contact),
        _ if answer.lower > 0.0 => Some(query == Query::Contact),
        _ => None,
    }
}

impl Tally {
    fn add(&mut self, query: Query, pair: &IndexedPair, gpu: &Answer, processor: &Answer) {
        let proofs = [proof(gpu, query), proof(processor, query)];
        let meet = query == Query::Intersects || (gpu.lower <= processor.upper && processor.lower <= gpu.upper);
        match proofs {
            _ if !meet => self.wrong += 1,
            [Some(true), Some(true)] => self.overlapping += 1,
            [Some(false), Some(false)] => self.separated += 1,
            [Some(_), Some(_)] => self.wrong += 1,
            [None, _] => self.open_on_gpu += 1,
            [Some(_), None] => self.open_on_processor += 1,
        }
        self.stalled += usize::from(gpu.status == Status::Stalled);
        if !meet || matches!(proofs, [Some(yes), Some(other)] if yes != other) {
            println!("wrong: {pair:?}: {gpu:?} on the GPU, {processor:?} on the processor");
        }
    }

    fn count(&self) -> usize {
        self.separated + self.overlapping + self.open_on_gpu + self.open_on_processor + self.wrong
    }
}

impl std::fmt::Display for Tally {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} pairs: {} separated, {} overlapping, {} open on the GPU, {} open on the processor alone, \
             {} stalled on the GPU, {} wrong; {:.0} s on the GPU, {:.0} s on the processor",
            self.count(),
            self.separated,
            self.overlapping,
            self.open_on_gpu,
            self.open_on_processor,
            self.stalled,
            self.wrong,
            self.seconds[0],
            self.seconds[1],
        )
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let Arguments { pairs, seed, hulls, query, first_pack } = arguments()?;
    let device = Device::open()?;
    println!("{}; {query:?}, {hulls} hulls, seed {seed}", device.description());
    let count = hulls.div_ceil(HULLS_OF_A_PACK);
    let mut tally = Tally::default();
    let mut vertices = [usize::MAX, 0];
    for at in first_pack - 1..count {
        let pack = bake(at, count, hulls, seed);
        let views: Vec<Hull<'_>> = (0..pack.hull_count()).map(|index| pack.hull(index)).collect::<Result<_, _>>()?;
        for hull in &views {
            vertices = [vertices[0].min(hull.vertex_count()), vertices[1].max(hull.vertex_count())];
        }
        let (mut gpu, mut processor) = (Batch::on(&device, &pack)?, Batch::new(&pack, Backend::Cpu)?);
        let mut rng = SplitMix64::new(seed.wrapping_add((at as u64) << 32));
        // All packs together have all pairs.
        let mut left = pairs * (at + 1) / count - pairs * at / count;
        while left > 0 {
            let block = left.min(BLOCK);
            let random: Vec<IndexedPair> = (0..block).map(|at| random_pair(&views, at, &mut rng)).collect();
            for (side, batch) in [&mut gpu, &mut processor].into_iter().enumerate() {
                let start = Instant::now();
                match query {
                    Query::Intersects => batch.intersects(&random)?,
                    Query::Distance => batch.distance(&random, &Settings::default())?,
                    Query::Contact => batch.contact(&random, &Settings::default())?,
                };
                tally.seconds[side] += start.elapsed().as_secs_f64();
            }
            for (pair, (gpu, processor)) in random.iter().zip(gpu.answers().iter().zip(processor.answers())) {
                tally.add(query, pair, gpu, processor);
            }
            left -= block;
        }
        eprintln!("pack {} of {count}, {} MB: {tally}", at + 1, pack.bytes().len() >> 20);
    }
    println!("{tally}; hulls of {} to {} vertices", vertices[0], vertices[1]);
    // A test that decides nothing proves nothing.
    let decided = |part: usize| part * 10 > tally.count();
    if tally.wrong > 0 || !decided(tally.separated) || !decided(tally.overlapping) {
        return Err("the GPU and the processor do not agree, or too little was decided".into());
    }
    Ok(())
}
