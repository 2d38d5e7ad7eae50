//! Reads bytes as two shapes and their poses. The [soak](crate::soak) judges the solver's answers
//! by certificates.

use glam::DVec3;
use hullmap::shapes::{Rounded, Scaled};
use hullmap::{Cache, Manifold, ManifoldSettings, Pack, Pose};
use hullmap_bake::IndexKind;
use hullmap_testkit::{
    packs::{self, point_set},
    reach::Reach as _,
};

use super::bytes::Bytes;
use crate::soak::{
    bodies::BodyPair,
    body::{Body, Kind, Solid},
    judge::judge_pair,
    meeting::Meeting,
    model::Model,
    tally::Tally,
};

const MAX_POINTS: usize = 32;

/// Number of poses of a pair.
const POSES: usize = 3;

/// A hull, its scale, and its convex radius.
struct Shape {
    pack: Pack,
    scale: DVec3,
    radius: f64,
}

/// Builds two shapes, runs all queries in a few poses, and judges the answers. Panics if an answer
/// is NaN, exceeds a limit, or has a wrong certificate.
pub fn solver(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let (Some(a), Some(b)) = (Shape::read(&mut bytes), Shape::read(&mut bytes)) else { return };
    let [a, b] = [&a, &b].map(Shape::body);
    let (mut tally, mut manifold, mut cache) = (Tally::default(), Manifold::new(), Cache::new());
    for index in 0..POSES as u64 {
        let Some(b_in_a) = pose(&mut bytes, &a, &b) else { return };
        let pair = BodyPair { index, seed: 0, bodies: [&a, &b], meeting: Meeting::Anywhere, b_in_a };
        judge_pair(&pair, &mut tally);
        let wrong: Vec<String> = tally.wrongs().map(|wrong| wrong.to_string()).collect();
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
        manifold.update(a.shape(), b.shape(), b_in_a, &ManifoldSettings::default(), &mut cache);
        let points = manifold.points();
        assert!(points.len() <= 4 && points.iter().all(|p| p.point_a.is_finite() && p.point_b.is_finite()));
        if bytes.is_empty() {
            return;
        }
    }
}

impl Shape {
    fn read(bytes: &mut Bytes) -> Option<Self> {
        let shape = bytes.byte();
        let size = 10_f64.powi(i32::from(shape / 8 % 13) - 6);
        let positions: Vec<[f32; 3]> =
            bytes.points(MAX_POINTS, false).iter().map(|p| p.map(|c| (f64::from(c) * size) as f32)).collect();
        let index = [IndexKind::Tree, IndexKind::None][usize::from(shape >> 7)];
        let file = packs::bytes(&[point_set("body", &positions)], index, &Default::default());
        let file = file.unwrap_or_else(|error| panic!("{error}: {positions:?}"));
        let pack = Pack::from_bytes(&file).expect("a baked pack opens");
        let scale = match shape % 4 {
            2 => DVec3::new(bytes.share(), bytes.share(), bytes.share()) * 4.0,
            _ => DVec3::ONE,
        };
        let radius = if shape % 4 == 3 { bytes.share().abs() * size } else { 0.0 };
        if scale.abs().min_element() <= 0.0 {
            return None;
        }
        Some(Self { pack, scale, radius })
    }

    fn body(&self) -> Body<'_> {
        let hull = self.pack.hull(0).expect("a pack has a hull");
        let model = Model::of_hull(&hull);
        let (solid, model) = if self.radius > 0.0 {
            let rounded = Rounded::new(hull, self.radius).expect("the radius is positive");
            (Solid::Shape(Box::new(rounded)), model.rounded(self.radius))
        } else if self.scale == DVec3::ONE {
            (Solid::Hull(hull), model)
        } else {
            let scaled = Scaled::new(hull, self.scale).expect("all factors are nonzero");
            (Solid::Shape(Box::new(scaled)), model.scaled(self.scale))
        };
        Body { name: "fuzzed".to_owned(), kind: Kind::Family, solid, model }
    }
}

/// A pose anywhere near, or one that touches along some axis up to an offset of any size.
fn pose(bytes: &mut Bytes, a: &Body<'_>, b: &Body<'_>) -> Option<Pose> {
    let (kind, rotation) = (bytes.below(3), bytes.rotation());
    let size = a.model.greatest + b.model.greatest;
    let translation = match kind {
        0 => DVec3::new(bytes.share(), bytes.share(), bytes.share()) * size,
        1 => DVec3::new(bytes.float().into(), bytes.float().into(), bytes.float().into()),
        _ => {
            let axis = bytes.axis();
            let hair = bytes.signed() * 10_f64.powi(-(bytes.below(17) as i32)) * size / 128.0;
            axis * (a.model.reach(axis) + b.model.reach(rotation.inverse() * -axis) + hair)
        }
    };
    Pose::new(translation, rotation).ok()
}
