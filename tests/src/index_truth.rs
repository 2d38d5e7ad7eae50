//! Direction indices of random hulls, judged from three sides: by their proof, by directions inside
//! of normal cones, and by damage.
//!
//! A direction inside of a vertex's normal cone needs no search: the vertex is its support vertex.
//! So millions of directions can be judged. Damaged indices show that the proof is not a formality:
//! a candidate that is removed from a leaf must be missed, unless no direction needs it there.

use glam::DVec3;
use hullmap::{Hull, Pack, SupportMap};
use hullmap_bake::{
    BakedHull, IndexKind, SourceRecord, bake_hull,
    hull::area::area_vector,
    index::certify::{Proof, Unproven, certify},
    write_pack,
};
use hullmap_format::archive::LANES;
use hullmap_testkit::packs::point_set;
use shapes::{capped::Capped, families::Family, rng::SplitMix64};

/// Maximum regret of an exact answer, by the project's definition.
const EXACT: f64 = 2e-7;

/// Number of directions in each normal cone that judge whether a removed candidate is needed.
const JUDGED: usize = 40;

/// A baked hull with the normals of the faces at each vertex.
pub struct Subject {
    /// Description for messages.
    pub name: String,
    /// The hull with its index.
    pub baked: BakedHull,
    positions: Vec<DVec3>,
    cones: Vec<Vec<DVec3>>,
}

/// Findings in a number of directions.
#[derive(Clone, Copy, Debug, Default)]
pub struct Answers {
    /// Number of directions.
    pub count: usize,
    /// Maximum regret, relative to the diameter.
    pub worst: f64,
    /// Number of answers that were not exact.
    pub wrong: usize,
}

/// Outcomes for indices with one candidate less.
#[derive(Clone, Copy, Debug, Default)]
pub struct Mutations {
    /// Number of damaged indices that could not be proven.
    pub found: usize,
    /// Number of damaged indices that were proven, and are exact: the candidate was not needed.
    pub harmless: usize,
    /// Number of damaged indices that were proven, but are not exact.
    pub missed: usize,
}

/// A random hull: of one of the families, or a capped solid, with a random index.
pub fn subject(rng: &mut SplitMix64) -> Subject {
    let seed = rng.state();
    let (name, points) = if rng.below(3) > 0 {
        let capped = Capped::random(rng);
        (format!("{capped:?}"), capped.points(rng))
    } else {
        let family = Family::ALL[rng.below(Family::ALL.len())];
        let count = 8 + rng.below(500);
        (format!("{family:?} {count}"), family.points(count, rng.next_u64()))
    };
    let kind = match rng.below(8) {
        0 => IndexKind::Medium,
        1 => IndexKind::Compact,
        2 => IndexKind::Binary,
        3 => IndexKind::CubeMap { resolution: 1 + rng.below(24) as u32 },
        _ => IndexKind::Tree,
    };
    Subject::new(format!("seed {seed:#x}: {name}, {kind}"), &points, kind)
}

impl Subject {
    /// Bakes points. Panics if they cannot be baked.
    pub fn new(name: String, points: &[[f32; 3]], kind: IndexKind) -> Self {
        let baked = bake_hull(&point_set("", points), kind).unwrap_or_else(|error| panic!("{name}: {error}"));
        let positions = baked.hull.positions();
        let mut cones = vec![Vec::new(); positions.len()];
        for face in &baked.hull.faces {
            let normal = area_vector(face, &positions).normalize();
            face.iter().for_each(|&vertex| cones[vertex as usize].push(normal));
        }
        Self { name, baked, positions, cones }
    }

    /// The proof of its index. The error is the reason why it is not proven.
    pub fn proof(&self) -> Result<Proof, Unproven> {
        self.baked.index.prove(&self.baked.hull)
    }

    /// Queries `count` directions in each vertex's normal cone, with vectors of f32 and of f64.
    pub fn query(&self, count: usize, rng: &mut SplitMix64) -> Answers {
        self.query_baked(&self.baked, count, rng)
    }

    fn query_baked(&self, baked: &BakedHull, count: usize, rng: &mut SplitMix64) -> Answers {
        let bytes = write_pack(std::slice::from_ref(baked), &SourceRecord::default()).expect("the hull was baked");
        let pack = Pack::from_bytes(&bytes).expect("the pack was written");
        let hull = pack.hull(0).expect("the pack has a hull");
        let mut answers = Answers::default();
        for (vertex, cone) in self.cones.iter().enumerate().filter(|(_, cone)| cone.len() > 2) {
            for _ in 0..count {
                self.judge(&hull, vertex, inside(cone, rng), &mut answers);
            }
        }
        answers
    }

    fn judge(&self, hull: &Hull, vertex: usize, dir: DVec3, answers: &mut Answers) {
        let narrow = dir.as_vec3();
        let in_f64 = hull.support_point(dir).point;
        let in_f32 = hull.support(narrow).point.as_dvec3();
        for (dir, got) in [(dir, in_f64), (narrow.as_dvec3(), in_f32)] {
            let loss = (self.positions[vertex] - got).dot(dir);
            let regret = loss / (dir.length() * self.baked.hull.diameter);
            answers.count += 1;
            answers.worst = answers.worst.max(regret);
            // NaN is wrong.
            answers.wrong += usize::from(!(regret <= EXACT));
        }
    }

    /// Removes candidates from blocks, one at a time: at most `most` of them, at random.
    pub fn mutate(&self, most: usize, rng: &mut SplitMix64) -> Mutations {
        let blocks = &self.baked.index.encoded.blocks;
        let mut mutations = Mutations::default();
        let lanes = blocks.len() * LANES;
        let all: Vec<usize> =
            if lanes <= most { (0..lanes).collect() } else { (0..most).map(|_| rng.below(lanes)).collect() };
        for at in all {
            let (index, lane) = (at / LANES, at % LANES);
            let block = &blocks[index];
            // Another lane's vertex takes its place.
            let Some(other) = (0..LANES).find(|other| block.vertex[*other] != block.vertex[lane]) else { continue };
            // Padding occurs several times, and last.
            if (0..LANES).any(|other| other != lane && block.vertex[other] == block.vertex[lane]) {
                continue;
            }
            let mut damaged = self.baked.clone();
            let block = &mut damaged.index.encoded.blocks[index];
            for lanes in [&mut block.x, &mut block.y, &mut block.z] {
                lanes[lane] = lanes[other];
            }
            block.vertex[lane] = block.vertex[other];
            let encoded = &damaged.index.encoded;
            let proof = certify(&damaged.hull, damaged.index.kind, &encoded.slots[..], encoded.blocks.iter().copied());
            if proof.is_err() {
                mutations.found += 1;
            } else if self.query_baked(&damaged, JUDGED, rng).wrong == 0 {
                mutations.harmless += 1;
            } else {
                mutations.missed += 1;
            }
        }
        mutations
    }
}

/// A direction inside of a cone: a mean of its corners with random weights, half of the time near
/// its border.
fn inside(cone: &[DVec3], rng: &mut SplitMix64) -> DVec3 {
    let sharpness = [1.0, 1.0, 4.0, 16.0][rng.below(4)];
    let weight = |rng: &mut SplitMix64| rng.unit().powf(sharpness) + 1e-9;
    let sum: DVec3 = cone.iter().map(|corner| *corner * weight(rng)).sum();
    sum.try_normalize().unwrap_or(cone[0])
}
