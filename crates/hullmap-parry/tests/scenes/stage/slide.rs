//! Bodies that slide and roll over a slab, whole or cut into parts. The cuts must have no effect:
//! the trajectory on the cut slab is compared with the one on the whole slab.

use std::sync::Arc;

use hullmap::glam::{DVec3, Quat};
use hullmap_parry::compound;
use hullmap_testkit::packs::{corners as box_corners, parts as parts_pack, point_set};
use rapier3d::parry::shape::Compound;
use rapier3d::prelude::*;

use super::model::{Model, prism};
use super::rest::STEP_SECONDS;
use super::slab::{Cut, HALF, corners};
use super::slab_sheet::{Form, colliders};
use super::way::Way;

/// The union of convex parts, as one shape. Panics if a part cannot be baked, or parry rejects it.
pub fn union(parts: &[Vec<DVec3>], way: Way) -> SharedShape {
    let single: Vec<Vec<[f32; 3]>> =
        parts.iter().map(|part| part.iter().map(|p| p.as_vec3().to_array()).collect()).collect();
    if way == Way::Parry {
        let hull = |points: &Vec<[f32; 3]>| {
            let points: Vec<Vector> = points.iter().map(|p| Vector::from_array(*p)).collect();
            SharedShape::convex_hull(&points).expect("parry takes the hull")
        };
        return match single.as_slice() {
            [one] => hull(one),
            many => SharedShape::new(Compound::new(many.iter().map(|part| (Pose::identity(), hull(part))).collect())),
        };
    }
    let sets: Vec<_> = single.iter().map(|points| point_set("part", points)).collect();
    compound(&Arc::new(parts_pack(&sets))).expect("at least one part")
}

/// A body that slides or rolls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slider {
    /// A box of 1 m that slides.
    Box,
    /// A box of 1 m that slides, turned by 30°.
    TurnedBox,
    /// A hull of 2,048 vertices near a sphere of 1 m, which rolls.
    Sphere,
    /// A ball of 1 m, which rolls.
    Ball,
    /// A cylinder of 1 m, which rolls.
    Cylinder,
    /// A prism of 64 sides with bevelled rims, which slides on its cap.
    Bevelled,
    /// A chair of six boxes that slides on its four legs of 5 cm.
    Chair,
}

impl Slider {
    /// Whether it rolls, so that it starts with a spin and has friction.
    fn rolls(self) -> bool {
        matches!(self, Self::Sphere | Self::Ball | Self::Cylinder)
    }

    /// The shape, about its origin. Its lowest point is 0.5 m below. Panics if a bake fails.
    pub fn shape(self, way: Way) -> SharedShape {
        let solid = |points: &[[f32; 3]]| Model::new("body", points).expect("a solid").shape(way);
        match self {
            Self::Box | Self::TurnedBox => solid(&box_corners([-0.5; 3], [0.5; 3])),
            Self::Sphere => {
                // Fibonacci's points: evenly spread, and no two at the same height.
                let point = |i: usize| {
                    let y = 1.0 - (2.0 * i as f64 + 1.0) / 2048.0;
                    let (r, angle) = ((1.0 - y * y).sqrt(), 2.399963229728653 * i as f64);
                    (DVec3::new(r * angle.cos(), y, r * angle.sin()) * 0.5).as_vec3().to_array()
                };
                solid(&(0..2048).map(point).collect::<Vec<_>>())
            }
            Self::Ball => SharedShape::ball(0.5),
            // Along z.
            Self::Cylinder => {
                let turned = Pose::from_parts(Vector::ZERO, Quat::from_rotation_x(std::f32::consts::FRAC_PI_2));
                match way {
                    Way::Parry => SharedShape::new(Compound::new(vec![(turned, SharedShape::cylinder(0.5, 0.5))])),
                    // A prism of 256 sides, since parry's cylinders on parry's hulls are no baked
                    // hulls.
                    Way::Shapes | Way::Dispatcher => {
                        let points: Vec<[f32; 3]> =
                            prism(256, 0.5, 0.5).hull.hull().vertices().map(|v| [v.x, v.z, -v.y]).collect();
                        solid(&points)
                    }
                }
            }
            Self::Bevelled => {
                let ring = |radius: f64, y: f64| {
                    (0..64).map(move |i| {
                        let angle = f64::from(i) / 64.0 * std::f64::consts::TAU;
                        [(radius * angle.cos()) as f32, y as f32, (radius * angle.sin()) as f32]
                    })
                };
                let rings = [(0.45, -0.5), (0.5, -0.45), (0.5, 0.45), (0.45, 0.5)];
                solid(&rings.into_iter().flat_map(|(radius, y)| ring(radius, y)).collect::<Vec<_>>())
            }
            Self::Chair => {
                let block = |low: [f64; 3], high: [f64; 3]| corners([DVec3::from(low), DVec3::from(high)]);
                let leg = |x: f64, z: f64| block([x, -0.5, z], [x + 0.05, 0.0, z + 0.05]);
                let parts = [
                    block([-0.25, 0.0, -0.25], [0.25, 0.05, 0.25]),
                    block([-0.25, 0.05, -0.25], [-0.2, 0.5, 0.25]),
                    leg(-0.25, -0.25),
                    leg(0.2, -0.25),
                    leg(-0.25, 0.2),
                    leg(0.2, 0.2),
                ];
                union(&parts, way)
            }
        }
    }
}

/// A slide: slab, slope, body.
#[derive(Clone, Copy, Debug)]
pub struct Slide {
    /// Form of the slab.
    pub form: Form,
    /// Cuts of the slab.
    pub cut: Cut,
    /// Slope of the slab along x, in degrees.
    pub degrees: f32,
    /// The body.
    pub slider: Slider,
}

/// A moment of a trajectory, in the frame of the slab.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    /// Position of the body's origin.
    pub position: Vector,
    /// Its velocity.
    pub velocity: Vector,
}

impl Slide {
    /// Runs the slide for `seconds`, and returns each step.
    pub fn run(&self, way: Way, seconds: f32) -> Vec<Moment> {
        let slope = Quat::from_rotation_z(-self.degrees.to_radians());
        let (rolls, flat) = (self.slider.rolls(), self.degrees == 0.0);
        // Sliding bodies are fast enough on the flat to cross several parts, and slow on the slope.
        let friction = if rolls {
            0.8
        } else if flat {
            0.1
        } else {
            0.2
        };
        let speed = if flat { 3.0 } else { 0.5 };
        let mut world = way.world();
        let slab = |shape: SharedShape| ColliderBuilder::new(shape).friction(friction);
        if self.form == Form::Hulls {
            // The parts are baked as they lie on the slope, so that they are rounded there.
            let turn = |p: &DVec3| slope.as_dquat() * *p;
            let parts: Vec<Vec<DVec3>> = self.cut.parts().iter().map(|part| part.iter().map(turn).collect()).collect();
            world.insert_collider(slab(union(&parts, way)), None);
        } else {
            for shape in colliders(self.form, self.cut, slope, way) {
                world.insert_collider(slab(shape), None);
            }
        }
        let velocity = slope * Vector::new(speed, 0.0, 0.11 * speed);
        let spin = if rolls { slope * Vector::new(0.22 * speed, 0.0, -2.0 * speed) } else { Vector::ZERO };
        let heading = if self.slider == Slider::TurnedBox { Quat::from_rotation_y(0.52) } else { Quat::IDENTITY };
        let at = Pose::from_parts(slope * Vector::new(-3.31, 0.5, -0.43), slope * heading);
        let body = RigidBodyBuilder::dynamic().pose(at).linvel(velocity).angvel(spin).can_sleep(false);
        let collider = ColliderBuilder::new(self.slider.shape(way)).friction(friction).density(100.0);
        let (body, _) = world.insert(body, collider);
        let mut moments = Vec::new();
        for _ in 0..(seconds / STEP_SECONDS).round() as u32 {
            world.step();
            let body = &world.bodies[body];
            let local = |v: Vector| slope.inverse() * v;
            moments.push(Moment { position: local(body.translation()), velocity: local(body.linvel()) });
        }
        moments
    }
}

/// How a trajectory differs from the trajectory on the whole slab.
#[derive(Clone, Copy, Debug, Default)]
pub struct Deviation {
    /// Maximum difference in height, in metres.
    pub height: f32,
    /// Maximum difference along and across the slab, in metres.
    pub place: f32,
    /// Maximum difference in speed, relative to the greatest speed.
    pub speed: f32,
    /// Number of steps in which the velocity off the slab is more than 2 cm/s greater than any on
    /// the whole slab within 5 steps.
    pub kicks: usize,
}

/// Compares two trajectories, of which `whole` is the reference. Ends where the body on the whole
/// slab leaves the slab.
pub fn deviation(whole: &[Moment], cut: &[Moment]) -> Deviation {
    let mut found = Deviation::default();
    let top = whole.iter().map(|m| m.velocity.length()).fold(0.0, f32::max);
    let on_slab = |m: &&Moment| m.position.x.abs().max(m.position.z.abs()) < HALF as f32 - 0.6;
    let steps = whole.iter().take_while(on_slab).count();
    for step in 0..steps.min(cut.len()) {
        let (a, b) = (&whole[step], &cut[step]);
        let apart = b.position - a.position;
        found.height = found.height.max(apart.y.abs());
        found.place = found.place.max(apart.x.hypot(apart.z));
        found.speed = found.speed.max((b.velocity.length() - a.velocity.length()).abs() / top);
        let near = &whole[step.saturating_sub(5)..(step + 6).min(whole.len())];
        let usual = near.iter().map(|m| m.velocity.y).fold(0.0, f32::max);
        found.kicks += usize::from(b.velocity.y > usual + 0.02);
    }
    found
}
