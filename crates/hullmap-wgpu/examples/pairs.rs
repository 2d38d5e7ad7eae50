//! Pairs per second on this machine's GPU, and on one thread of its processor.
//!
//!     cargo run --release --example pairs
//!     cargo run --release --example pairs -- --pairs 4000000 --out results.jsonl
//!
//! Each row is the median of several batches of one pack: random pairs of smooth hulls, half of
//! them overlapping, that move by a hundredth from batch to batch. `kernel` is the time of the
//! kernels by the clock of the device. `batch` is the time of the whole call: preparing on the
//! processor, copying, solving and reading back. `--out` appends a dated line of JSON for each row.

use std::io::Write;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use hullmap::glam::{DQuat, DVec3};
use hullmap::{Pack, Pose, Settings, SupportMap};
use hullmap_bake::IndexKind;
use hullmap_testkit::{packs, random::RandomPoses};
use hullmap_wgpu::{Backend, Batch, Device, IndexedPair, Query};
use shapes::{families, rng::SplitMix64};

/// Different hulls of each size.
const HULLS: usize = 4;

struct Arguments {
    pairs: usize,
    batches: usize,
    vertices: Vec<usize>,
    out: Option<String>,
}

#[expect(clippy::disallowed_methods, reason = "a program has arguments")]
fn arguments() -> Result<Arguments, String> {
    let mut found = Arguments { pairs: 1 << 20, batches: 5, vertices: vec![64, 1_024, 65_536], out: None };
    let mut words = std::env::args().skip(1);
    while let Some(name) = words.next() {
        let value = words.next().ok_or_else(|| format!("{name} requires a value"))?;
        let number = || value.parse::<usize>().map_err(|error| format!("{name} {value}: {error}"));
        match name.as_str() {
            "--pairs" => found.pairs = number()?.max(1),
            "--batches" => found.batches = number()?.max(1),
            "--vertices" => found.vertices = vec![number()?.max(8)],
            "--out" => found.out = Some(value),
            _ => return Err(format!("unknown option {name}: expected --pairs, --batches, --vertices or --out")),
        }
    }
    Ok(found)
}

fn bake(vertices: usize) -> Pack {
    let sets: Vec<_> =
        (0..HULLS).map(|seed| packs::point_set("hull", &families::sphere(vertices, seed as u64))).collect();
    let bytes = packs::bytes(&sets, IndexKind::Tree, &Default::default()).expect("the families can be baked");
    Pack::from_bytes(&bytes).expect("a baked pack opens")
}

/// Half of the pairs of balls of radius 1 overlap.
fn random_pairs(pack: &Pack, count: usize) -> Vec<IndexedPair> {
    let mut rng = SplitMix64::new(1);
    let center = |index: usize| pack.hull(index).map_or(DVec3::ZERO, |hull| hull.interior_point());
    let pair = |_| {
        let (a, b) = (rng.below(HULLS), rng.below(HULLS));
        let rotation = rng.rotation();
        let translation = center(a) + rng.unit_vector() * rng.between(1.0, 3.0) - rotation * center(b);
        IndexedPair { a: a as u32, b: b as u32, b_in_a: Pose::new(translation, rotation).expect("finite") }
    };
    (0..count).map(pair).collect()
}

fn a_frame_later(pairs: &mut [IndexedPair], rng: &mut SplitMix64) {
    for pair in pairs {
        let turn = DQuat::from_axis_angle(rng.unit_vector(), 0.01);
        let translation = pair.b_in_a.translation() + rng.unit_vector() * 0.01;
        pair.b_in_a = Pose::new(translation, turn * pair.b_in_a.rotation()).expect("finite");
    }
}

fn solve(batch: &mut Batch<'_>, query: Query, pairs: &[IndexedPair]) -> Result<(), hullmap_wgpu::Error> {
    match query {
        Query::Intersects => batch.intersects(pairs).map(drop),
        Query::Distance => batch.distance(pairs, &Settings::default()).map(drop),
        Query::Contact => batch.contact(pairs, &Settings::default()).map(drop),
    }
}

fn median(mut times: Vec<f64>) -> Option<f64> {
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied()
}

/// The date of today, in UTC. H. Hinnant, "chrono-compatible low-level date algorithms".
fn today() -> String {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    let days = seconds / 86_400 + 719_468;
    let (era, day_of_era) = (days / 146_097, days % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1_460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * shifted + 2) / 5 + 1;
    let month = if shifted < 10 { shifted + 3 } else { shifted - 9 };
    let year = era * 400 + year_of_era + u64::from(month <= 2);
    format!("{year:04}-{month:02}-{day:02}")
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments = arguments()?;
    let device = Device::open()?;
    let (adapter, date) = (device.description(), today());
    println!("{adapter}\n{date}, {} pairs a batch, median of {} batches\n", arguments.pairs, arguments.batches);
    println!("vertices  query       start     million pairs/s: kernel    batch  processor, 1 thread  open");
    let mut out = match &arguments.out {
        Some(path) => Some(std::fs::OpenOptions::new().create(true).append(true).open(path)?),
        None => None,
    };
    for vertices in arguments.vertices {
        let pack = bake(vertices);
        let mut processor = Batch::new(&pack, Backend::Cpu)?;
        for query in [Query::Intersects, Query::Distance, Query::Contact] {
            let few = random_pairs(&pack, arguments.pairs.min(20_000));
            let start = Instant::now();
            solve(&mut processor, query, &few)?;
            let on_processor = few.len() as f64 / start.elapsed().as_secs_f64() / 1e6;
            for (name, is_warm) in [("cold", false), ("warm", true)] {
                let mut pairs = random_pairs(&pack, arguments.pairs);
                let mut rng = SplitMix64::new(2);
                let mut batch = Batch::on(&device, &pack)?;
                batch.set_warm(is_warm);
                // The first batch makes the buffers, and the state from which the next one starts.
                solve(&mut batch, query, &pairs)?;
                let (mut whole, mut kernels) = (Vec::new(), Vec::new());
                for _ in 0..arguments.batches {
                    a_frame_later(&mut pairs, &mut rng);
                    let start = Instant::now();
                    solve(&mut batch, query, &pairs)?;
                    whole.push(start.elapsed().as_secs_f64());
                    kernels.extend(batch.kernel_seconds());
                }
                let rate = |times| median(times).map_or(f64::NAN, |seconds| pairs.len() as f64 / seconds / 1e6);
                let (kernel, whole) = (rate(kernels), rate(whole));
                let open = batch.answers().iter().filter(|answer| answer.status.is_unsettled()).count();
                let open = open as f64 / pairs.len() as f64;
                let query = format!("{query:?}").to_lowercase();
                println!(
                    "{vertices:8}  {query:10}  {name:8}  {kernel:23.3}  {whole:7.3}  {on_processor:19.3}  \
                     {open:.4}"
                );
                if let Some(out) = &mut out {
                    // JSON has no NaN.
                    let kernel = if kernel.is_finite() { kernel.to_string() } else { "null".to_owned() };
                    writeln!(
                        out,
                        "{{\"date\":\"{date}\",\"adapter\":{adapter:?},\"vertices\":{vertices},\"query\":\"{query}\",\
                         \"start\":\"{name}\",\"pairs\":{},\"kernel_million_per_second\":{kernel},\
                         \"batch_million_per_second\":{whole},\"processor_million_per_second\":{on_processor},\
                         \"open\":{open}}}",
                        pairs.len()
                    )?;
                }
            }
        }
    }
    Ok(())
}
