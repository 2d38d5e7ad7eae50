//! Records that the kernels read and write, and their preparation on the processor.
//!
//! A pair is prepared in f64: the centre v₀ of the Minkowski difference, the rotation, and a bound
//! on every rounding error of the kernel (`rounding`). Only then are the numbers rounded to f32. So
//! shapes far from the origins of their frames lose no digits, and the kernels need no lengths
//! other than the lengths of the shapes. All lengths of a pair are multiplied by a power of two
//! that brings them to about 1. That is exact, and nothing can overflow.

use std::borrow::Cow;

use bytemuck::{Pod, Zeroable};
use hullmap::glam::DVec3;
use hullmap::{Hull, Pack, Pose, SupportMap};
use hullmap_format::sections::Sections;

use crate::error::Error;
use crate::rounding::rounding_error;

/// Lengths of a pair must be within this range, so that the scale and its inverse are f32.
const LENGTHS: std::ops::RangeInclusive<f64> = 1e-30..=1e30;

/// Resolutions of a cube map from here on have more cells than a pack has words.
const MAX_RESOLUTION: u32 = 1 << 20;

/// Support calls of a pair. About 10 are usual.
pub const MAX_STEPS: u32 = 64;

/// Which question a pair is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Query {
    /// Yes or no: stop at the first proof.
    Intersects,
    /// The distance, until the interval is within the tolerance.
    Distance,
    /// The penetration depth, until the interval is within the tolerance.
    Contact,
}

/// Input of the kernels for one hull: 48 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct HullRecord {
    /// The interior point, rounded to f32.
    pub(crate) center: [f32; 3],
    /// Radius of a ball around `center` that contains the hull.
    pub(crate) outer: f32,
    /// Radius of a ball around `center` inside the hull; 0 if there is none.
    pub(crate) inner: f32,
    /// Kind of the direction index, as in the file.
    pub(crate) kind: u32,
    /// Resolution of a cube map.
    pub(crate) resolution: u32,
    /// Blocks of a plain leaf.
    pub(crate) leaf_blocks: u32,
    /// Start of the hull's words in `slots`.
    pub(crate) slot_start: u32,
    pub(crate) slot_count: u32,
    pub(crate) block_start: u32,
    /// Number of its blocks. 0 for a hull that an unchecked pack lacks.
    pub(crate) block_count: u32,
}

impl HullRecord {
    fn new(hull: &Hull<'_>, sections: &Sections<'_>, index: usize) -> Option<Self> {
        let record = sections.hulls.get(index)?;
        let (start, end) = (sections.spans.get(index)?, sections.spans.get(index + 1)?);
        let center = hull.interior_point().as_vec3();
        let moved = center.as_dvec3().distance(hull.interior_point());
        let resolution = record.resolution.to_native();
        (resolution < MAX_RESOLUTION).then_some(Self {
            center: center.to_array(),
            outer: round_up((hull.outer_radius() + moved) * (1.0 + 1e-12)),
            inner: round_down((hull.inner_radius() - moved) * (1.0 - 1e-12)).max(0.0),
            kind: record.index_kind.to_native(),
            resolution,
            leaf_blocks: record.leaf_blocks.to_native(),
            slot_start: start.slot.to_native(),
            slot_count: end.slot.to_native() - start.slot.to_native(),
            block_start: start.block.to_native(),
            block_count: end.block.to_native() - start.block.to_native(),
        })
    }
}

/// The sections of packs that the kernels read, and a record for each hull.
#[derive(Clone, Debug)]
pub(crate) struct Tables<'a> {
    pub(crate) hulls: Vec<HullRecord>,
    /// The section `blocks`, unchanged: 32 words per block. The blocks of several packs are joined.
    pub(crate) blocks: Cow<'a, [u32]>,
    pub(crate) slots: Cow<'a, [u32]>,
}

impl<'a> Tables<'a> {
    /// The tables of `pack`.
    ///
    /// A hull that a pack opened without checks lacks has a record without blocks.
    pub(crate) fn from_pack(pack: &'a Pack) -> Result<Self, Error> {
        if cfg!(target_endian = "big") {
            return Err(Error::Pack);
        }
        let payload = pack.bytes().get(hullmap_format::header::HEADER_LEN..).ok_or(Error::Pack)?;
        let sections = Sections::read(payload).map_err(|_| Error::Pack)?;
        let record = |index: usize| {
            let hull = pack.hull(index).ok()?;
            HullRecord::new(&hull, &sections, index)
        };
        Ok(Self {
            hulls: (0..pack.hull_count()).map(|index| record(index).unwrap_or_default()).collect(),
            blocks: Cow::Borrowed(bytemuck::try_cast_slice(sections.blocks).map_err(|_| Error::Pack)?),
            slots: Cow::Borrowed(bytemuck::try_cast_slice(sections.slots).map_err(|_| Error::Pack)?),
        })
    }

    /// The tables of several packs. Hulls are counted through the packs.
    pub(crate) fn from_packs(packs: &[&'a Pack]) -> Result<Self, Error> {
        let mut joined = Self { hulls: Vec::new(), blocks: Cow::Borrowed(&[]), slots: Cow::Borrowed(&[]) };
        for pack in packs {
            let tables = Self::from_pack(pack)?;
            let start = |section: &'static str, words: &[u32], more: &[u32]| {
                let found = 4 * (words.len() as u64 + more.len() as u64);
                let fits = u32::try_from(found / 4).is_ok();
                let start = words.len() as u32;
                if fits { Ok(start) } else { Err(Error::TooLarge { section, found, limit: 4 << 32 }) }
            };
            let first_block = start("blocks", &joined.blocks, &tables.blocks)? / 32;
            let first_slot = start("slots", &joined.slots, &tables.slots)?;
            joined.hulls.extend(tables.hulls.into_iter().map(|mut hull| {
                hull.block_start += first_block;
                hull.slot_start += first_slot;
                hull
            }));
            if joined.blocks.is_empty() && joined.slots.is_empty() {
                (joined.blocks, joined.slots) = (tables.blocks, tables.slots);
            } else {
                joined.blocks.to_mut().extend_from_slice(&tables.blocks);
                joined.slots.to_mut().extend_from_slice(&tables.slots);
            }
        }
        Ok(joined)
    }
}

/// Two hulls and a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IndexedPair {
    /// Index of hull A in the pack, or in all packs of the batch.
    pub a: u32,
    /// Index of hull B, likewise.
    pub b: u32,
    /// B's pose in A's frame.
    pub b_in_a: Pose,
}

/// Input of the kernels for one pair: 64 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PairRecord {
    /// The rows of the rotation, each followed by a coordinate of the scaled centre v₀.
    pub rows: [[f32; 4]; 3],
    /// Index of hull A; [`PairRecord::REJECTED`] if the pair cannot be solved.
    pub a: u32,
    /// Index of hull B.
    pub b: u32,
    /// Bound on all rounding errors of a support value or of a point, scaled.
    pub rounding: f32,
    /// Power of two by which lengths are multiplied.
    pub scale: f32,
}

impl PairRecord {
    /// Instead of a hull's index: there is no such hull, or the lengths are out of range.
    pub const REJECTED: u32 = u32::MAX;

    pub(crate) fn prepare(pair: &IndexedPair, hulls: &[HullRecord]) -> Self {
        Self::try_prepare(pair, hulls).unwrap_or(Self { a: Self::REJECTED, ..Self::default() })
    }

    fn try_prepare(pair: &IndexedPair, hulls: &[HullRecord]) -> Option<Self> {
        let whole = |index: u32| hulls.get(index as usize).filter(|hull| hull.block_count > 0);
        let (a, b) = (whole(pair.a)?, whole(pair.b)?);
        let (center_a, center_b) = (point(a.center), point(b.center));
        let (rotation, translation) = (pair.b_in_a.rotation_matrix(), pair.b_in_a.translation());
        let center = center_a - (rotation * center_b + translation);
        let radii = f64::from(a.outer) + f64::from(b.outer);
        let reach = center.length() + radii;
        // NaN takes the failing branch.
        if !LENGTHS.contains(&reach) {
            return None;
        }
        let double = center_a.length() + center_b.length() + translation.length() + reach;
        let rounding = rounding_error(radii, center.length(), double);
        let scale = power_of_two_below(1.0 / reach);
        let row = |axis: usize| {
            let [x, y, z] = rotation.row(axis).as_vec3().to_array();
            [x, y, z, (center * scale).as_vec3().to_array()[axis]]
        };
        Some(Self {
            rows: [row(0), row(1), row(2)],
            a: pair.a,
            b: pair.b,
            rounding: round_up(rounding * scale),
            scale: scale as f32,
        })
    }
}

/// How a pair ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Status {
    /// A plane proves the hulls separated. The interval of a distance is within the tolerance; a
    /// depth is 0.
    Separated,
    /// The hulls overlap. The interval of a depth is within the tolerance; a distance is 0.
    Overlapping,
    /// Neither is proven: the interval of the distance or depth holds 0.
    Open,
    /// Proven separated (for a depth: proven overlapping), but f32 stopped all progress before the
    /// interval was within the tolerance.
    Stalled,
    /// The steps, or the nodes and blocks of the index, ran out. The interval is valid.
    Budget,
    /// There is no such hull, or lengths are beyond the range of f32. The interval is [0, ∞).
    Rejected,
}

impl Status {
    /// The status in snake case. The names are stable.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Separated => "separated",
            Self::Overlapping => "overlapping",
            Self::Open => "open",
            Self::Stalled => "stalled",
            Self::Budget => "budget",
            Self::Rejected => "rejected",
        }
    }

    /// Whether the processor could say more: everything but a proven answer within the tolerance.
    pub fn is_unsettled(self) -> bool {
        !matches!(self, Self::Separated | Self::Overlapping)
    }
}

/// The numbers of [`Status`] in the kernels.
pub(crate) mod code {
    pub(crate) const SEPARATED: u32 = 0;
    pub(crate) const OVERLAPPING: u32 = 1;
    pub(crate) const OPEN: u32 = 2;
    pub(crate) const STALLED: u32 = 3;
    pub(crate) const BUDGET: u32 = 4;
}

/// Output of the kernels for one pair: 64 bytes. Lengths are scaled.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub struct AnswerRecord {
    /// Normal of the plane of the best bound, from A to B.
    pub normal: [f32; 3],
    /// Lower bound of the distance or depth.
    pub lower: f32,
    /// A's witness point, relative to A's centre.
    pub offset: [f32; 3],
    /// Upper bound of the distance or depth.
    pub upper: f32,
    /// A's witness point minus B's.
    pub between: [f32; 3],
    /// A number of [`Status`].
    pub status: u32,
    /// Support calls: each queries both hulls once.
    pub steps: u32,
    /// Nodes and blocks of both indices that were read.
    pub reads: u32,
    /// Padding.
    pub padding: [u32; 2],
}

impl AnswerRecord {
    /// The record as words. Two records are the same bit for bit if these are equal.
    pub fn bits(&self) -> [u32; 16] {
        bytemuck::cast(*self)
    }

    /// The status.
    pub fn status(&self) -> Status {
        match self.status {
            code::SEPARATED => Status::Separated,
            code::OVERLAPPING => Status::Overlapping,
            code::OPEN => Status::Open,
            code::STALLED => Status::Stalled,
            code::BUDGET => Status::Budget,
            _ => Status::Rejected,
        }
    }
}

/// Distance or penetration depth of a pair, with the interval that contains it. Points are in A's
/// frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    /// How the pair ended.
    pub status: Status,
    /// Lower bound of the distance, or of the depth, at least 0.
    pub lower: f64,
    /// Upper bound of the distance, or of the depth.
    pub upper: f64,
    /// Normal from A to B of the planes that prove `lower` of a distance, or `upper` of a depth.
    /// Its length is 1 within 1e-6.
    pub normal: DVec3,
    /// Witness point of A, a point of A within rounding error: the closest to B, or the deepest in
    /// B.
    pub point_a: DVec3,
    /// Witness point of B.
    pub point_b: DVec3,
    /// Number of support calls.
    pub steps: u32,
}

impl Answer {
    /// The answer that claims nothing.
    pub(crate) const UNKNOWN: Self = Self {
        status: Status::Rejected,
        lower: 0.0,
        upper: f64::INFINITY,
        normal: DVec3::X,
        point_a: DVec3::ZERO,
        point_b: DVec3::ZERO,
        steps: 0,
    };

    /// The answer in the pack's unit and A's frame.
    pub(crate) fn from_record(record: &AnswerRecord, pair: &PairRecord, hulls: &[HullRecord]) -> Self {
        let Some(a) = hulls.get(pair.a as usize) else { return Self::UNKNOWN };
        let back = 1.0 / f64::from(pair.scale);
        let point_a = point(a.center) + point(record.offset) * back;
        Self {
            status: record.status(),
            lower: f64::from(record.lower) * back,
            upper: f64::from(record.upper) * back,
            normal: point(record.normal),
            point_a,
            point_b: point_a - point(record.between) * back,
            steps: record.steps,
        }
    }
}

fn point(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

fn round_up(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) < x { near.next_up() } else { near }
}

fn round_down(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) > x { near.next_down() } else { near }
}

/// The largest power of two that is at most `x`, which is positive and normal.
fn power_of_two_below(x: f64) -> f64 {
    f64::from_bits(x.to_bits() & !((1 << 52) - 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roundings_are_to_the_safe_side() {
        for x in [0.1, 1.0 / 3.0, 1e-20, 12345.678901, 1.0] {
            assert!(f64::from(round_up(x)) >= x && f64::from(round_down(x)) <= x);
            assert!(f64::from(round_up(x)) <= x * (1.0 + 2.0 * crate::rounding::EPSILON));
            let power = power_of_two_below(x);
            assert!(power <= x && x < 2.0 * power && power.log2().fract() == 0.0);
        }
    }

    #[test]
    fn pairs_are_scaled_to_one_and_bad_ones_rejected() {
        let hull = HullRecord { outer: 3.0, block_count: 1, ..HullRecord::default() };
        let hulls = [hull, HullRecord { outer: f32::NAN, ..hull }, HullRecord::default()];
        for x in [0.0, 1.0, -5e6, 1e20] {
            let b_in_a = Pose::from_translation(DVec3::new(x, 0.0, 0.0)).unwrap();
            let record = PairRecord::prepare(&IndexedPair { a: 0, b: 0, b_in_a }, &hulls);
            let reach = f64::from(record.scale) * (x.abs() + 6.0);
            assert!(reach > 0.5 && reach <= 1.0, "{reach}");
            assert_eq!(record.rows[0][3], (-x * f64::from(record.scale)) as f32);
            for (a, b) in [(0, 1), (2, 0), (0, 3)] {
                assert_eq!(PairRecord::prepare(&IndexedPair { a, b, b_in_a }, &hulls).a, PairRecord::REJECTED);
            }
        }
        let far = Pose::from_translation(DVec3::splat(1e35)).unwrap();
        assert_eq!(PairRecord::prepare(&IndexedPair { a: 0, b: 0, b_in_a: far }, &hulls).a, PairRecord::REJECTED);
    }
}
