//! Shapes for tests: a point cloud by linear scan, and closed forms.

use ::shapes::rng::SplitMix64;
use glam::DVec3;
use hullmap::{Pose, Shape, SupportMap, SupportPoint};
use hullmap_testkit::random::RandomPoses;

/// The convex hull of a few points with the slow, obvious support mapping: a linear scan.
#[derive(Clone, Debug)]
pub struct PointCloud {
    pub points: Vec<DVec3>,
    pub interior: DVec3,
    pub inner_radius: f64,
    pub outer_radius: f64,
    pub support_error: f64,
    /// Whether its dot products are rounded to f32.
    pub is_single: bool,
}

impl PointCloud {
    /// A point cloud with the centroid as its interior point, and without an inner ball.
    pub fn new(points: Vec<DVec3>) -> Self {
        let interior = points.iter().sum::<DVec3>() / points.len() as f64;
        Self::around(points, interior)
    }

    /// A point cloud with the given interior point.
    pub fn around(points: Vec<DVec3>, interior: DVec3) -> Self {
        let outer_radius = points.iter().map(|p| p.distance(interior)).fold(0.0, f64::max);
        Self { points, interior, inner_radius: 0.0, outer_radius, support_error: 0.0, is_single: false }
    }

    /// A box with half edges `h`, as eight points.
    pub fn cuboid(h: DVec3) -> Self {
        let corners = (0..8).map(|i| {
            let sign = |bit: i32| if i & bit == 0 { -1.0 } else { 1.0 };
            DVec3::new(sign(1), sign(2), sign(4)) * h
        });
        Self { inner_radius: h.min_element(), ..Self::around(corners.collect(), DVec3::ZERO) }
    }

    /// A regular polygon in the plane z = 0.
    pub fn polygon(corners: usize, radius: f64) -> Self {
        let turn = std::f64::consts::TAU / corners as f64;
        Self::around(
            (0..corners).map(|i| DVec3::new((turn * i as f64).cos(), (turn * i as f64).sin(), 0.0) * radius).collect(),
            DVec3::ZERO,
        )
    }

    /// Both ends of a segment along x.
    pub fn segment(half: f64) -> Self {
        Self::new(vec![DVec3::X * half, DVec3::NEG_X * half])
    }

    pub fn point(p: DVec3) -> Self {
        Self::new(vec![p])
    }

    /// `count` random points in, or on, an ellipsoid.
    pub fn random(rng: &mut SplitMix64, count: usize, on_surface: bool) -> Self {
        let axes = DVec3::new(rng.between(0.3, 1.0), rng.between(0.3, 1.0), rng.between(0.3, 1.0));
        let points = (0..count)
            .map(|_| {
                let r = if on_surface { 1.0 } else { rng.between(0.2, 1.0) };
                rng.unit_vector() * axes * r
            })
            .collect();
        Self::new(points)
    }

    /// The points scaled from the origin of the frame.
    pub fn scaled(&self, scale: f64) -> Self {
        Self {
            points: self.points.iter().map(|p| *p * scale).collect(),
            interior: self.interior * scale,
            inner_radius: self.inner_radius * scale,
            outer_radius: self.outer_radius * scale,
            support_error: self.support_error * scale,
            ..*self
        }
    }

    /// The points in A's frame.
    pub fn placed(&self, pose: Pose) -> Vec<DVec3> {
        self.points.iter().map(|p| pose.transform_point(*p)).collect()
    }
}

impl SupportMap for PointCloud {
    fn support_point(&self, dir: DVec3) -> SupportPoint {
        let height = |p: DVec3| if self.is_single { p.as_vec3().dot(dir.as_vec3()).into() } else { p.dot(dir) };
        let mut best = 0;
        for (i, p) in self.points.iter().enumerate() {
            if height(*p) > height(self.points[best]) {
                best = i;
            }
        }
        SupportPoint { point: self.points[best], feature: best as u32 }
    }
    fn support_error(&self) -> f64 {
        self.support_error
    }
    fn interior_point(&self) -> DVec3 {
        self.interior
    }
    fn inner_radius(&self) -> f64 {
        self.inner_radius
    }
    fn outer_radius(&self) -> f64 {
        self.outer_radius
    }
    fn point(&self, feature: u32) -> Option<DVec3> {
        self.points.get(feature as usize).copied()
    }
}

impl Shape for PointCloud {}

/// A sphere, in closed form.
#[derive(Clone, Copy, Debug)]
pub struct Ball {
    pub center: DVec3,
    pub radius: f64,
    /// Whether `inner_radius` is the radius; 0 otherwise.
    pub has_inner_ball: bool,
}

impl SupportMap for Ball {
    fn support_point(&self, dir: DVec3) -> SupportPoint {
        let n = dir.try_normalize().unwrap_or(DVec3::X);
        SupportPoint { point: self.center + n * self.radius, feature: 0 }
    }
    fn interior_point(&self) -> DVec3 {
        self.center
    }
    fn inner_radius(&self) -> f64 {
        if self.has_inner_ball { self.radius } else { 0.0 }
    }
    fn outer_radius(&self) -> f64 {
        self.radius
    }
}

impl Shape for Ball {}

/// A box around the origin of its frame, in closed form.
#[derive(Clone, Copy, Debug)]
pub struct Cuboid(pub DVec3);

impl SupportMap for Cuboid {
    fn support_point(&self, dir: DVec3) -> SupportPoint {
        let side = |d: f64, h: f64| if d < 0.0 { -h } else { h };
        let h = self.0;
        let point = DVec3::new(side(dir.x, h.x), side(dir.y, h.y), side(dir.z, h.z));
        let feature = u32::from(dir.x < 0.0) | u32::from(dir.y < 0.0) << 1 | u32::from(dir.z < 0.0) << 2;
        SupportPoint { point, feature }
    }
    fn interior_point(&self) -> DVec3 {
        DVec3::ZERO
    }
    fn inner_radius(&self) -> f64 {
        self.0.min_element()
    }
    fn outer_radius(&self) -> f64 {
        self.0.length()
    }
}

impl Shape for Cuboid {}
