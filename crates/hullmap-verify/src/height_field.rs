//! Verification of a height field against the heights of its source.
//!
//! 1. Compare each cell with its samples: whether it is a hole, and the heights of its corners.
//! 2. Random vertical rays must meet the surface at heights computed from the samples alone. Every
//!    other ray is exactly above an edge or a sample.

use glam::DVec3;
use hullmap::height_field::{Diagonal, Layout};
use hullmap::{CastSettings, HeightField, Ray, Status};

use crate::joints::Answer;
use crate::random::SplitMix;
use crate::triangle_mesh::{Findings, SurfaceVerification};

/// Difference of heights that rounding explains, relative to the largest height of the field and
/// to its extent: of a few sums in f64, and of the ray's interval.
const ROUNDING: f64 = 1e-12;

/// Heights of a source on the grid that the field must have.
#[derive(Clone, Debug)]
pub struct SourceHeights {
    /// The grid.
    pub layout: Layout,
    /// Heights, row by row, the row with the least y first; NaN without ground.
    pub heights: Vec<f32>,
    /// Whether each cell is a hole; empty if heights alone decide.
    pub holes: Vec<bool>,
}

impl SourceHeights {
    /// The heights that a field stores.
    fn stored(field: &HeightField) -> Self {
        let layout = *field.layout();
        let [across, along] = layout.cells();
        let vertices = (0..layout.rows).flat_map(|row| (0..layout.columns).map(move |column| (column, row)));
        let height = |(column, row)| field.vertex(column, row).map_or(f32::NAN, |vertex| vertex.z as f32);
        let cells = (0..along).flat_map(|row| (0..across).map(move |column| (column, row)));
        let holes = cells.map(|(column, row)| field.is_hole(column, row)).collect();
        Self { layout, heights: vertices.map(height).collect(), holes }
    }

    fn corners(&self, column: usize, row: usize) -> [f64; 4] {
        let sample = |dx: usize, dy: usize| self.heights.get(self.layout.vertex(column + dx, row + dy));
        [sample(0, 0), sample(1, 0), sample(0, 1), sample(1, 1)].map(|z| f64::from(z.copied().unwrap_or(f32::NAN)))
    }

    fn is_hole(&self, column: usize, row: usize) -> bool {
        self.corners(column, row).iter().any(|z| z.is_nan())
            || self.holes.get(self.layout.cell(column, row)).copied().unwrap_or_default()
    }
}

/// Verifies a height field. Without a source, its own heights are the truth for the rays.
/// Complexity: O(cells + rays · log(cells)).
pub fn verify_field(
    field: &HeightField,
    source: Option<&SourceHeights>,
    rays: usize,
    seed: u64,
) -> SurfaceVerification {
    let answer: &Answer = &|ray| hullmap::ray(field, ray, &CastSettings::default());
    verify_answers(field, source, rays, seed, answer)
}

fn verify_answers(
    field: &HeightField,
    source: Option<&SourceHeights>,
    rays: usize,
    seed: u64,
    answer: &Answer,
) -> SurfaceVerification {
    let mut findings = Findings::default();
    let own;
    let truth = match source {
        Some(source) => source,
        None => {
            own = SourceHeights::stored(field);
            &own
        }
    };
    let (mut joint_rays, mut hits) = (0, 0);
    findings.compare("grid", field.layout(), &truth.layout);
    if field.layout() == &truth.layout {
        compare_cells(field, truth, &mut findings);
        let mut random = SplitMix::new(seed);
        for index in 0..rays {
            let place = [0.5 + 0.5 * random.signed(), 0.5 + 0.5 * random.signed()];
            let is_on_edge = index % 2 == 0;
            let Some((problem, is_hit)) = compare_ray(field, truth, place, is_on_edge, answer) else { continue };
            joint_rays += usize::from(is_on_edge);
            hits += usize::from(is_hit);
            problem.into_iter().for_each(|problem| findings.add(|| problem));
        }
    }
    SurfaceVerification {
        against: Some(if source.is_some() { "source" } else { "stored heights" }),
        triangles: Some(field.triangle_count() - 2 * field.hole_count()),
        rays: Some(rays),
        joint_rays: Some(joint_rays),
        ray_hits: Some(hits),
        seed: Some(seed),
        ..findings.verification()
    }
}

/// Step 1.
fn compare_cells(field: &HeightField, truth: &SourceHeights, findings: &mut Findings) {
    let [across, along] = truth.layout.cells();
    for (column, row) in (0..along).flat_map(|row| (0..across).map(move |column| (column, row))) {
        let is_hole = truth.is_hole(column, row);
        let cell = || format!("cell at column {column}, row {row}");
        if field.is_hole(column, row) != is_hole {
            let [found, expected] = if is_hole { ["ground", "a hole"] } else { ["a hole", "ground"] };
            findings.add(|| format!("{} differs: {found} instead of {expected}", cell()));
        } else if !is_hole {
            let vertex = |dx: usize, dy: usize| field.vertex(column + dx, row + dy).map_or(f64::NAN, |vertex| vertex.z);
            let found = [vertex(0, 0), vertex(1, 0), vertex(0, 1), vertex(1, 1)];
            let expected = truth.corners(column, row);
            if found != expected {
                findings.add(|| format!("{} differs: heights {found:?} instead of {expected:?}", cell()));
            }
        }
    }
}

/// Step 2: compares a vertical ray with the samples around it, at a place between 0 and 1 along x
/// and y, or on the nearest edge or sample below it. Returns the problem, and whether it hits;
/// `None` if its answer is not known.
fn compare_ray(
    field: &HeightField,
    truth: &SourceHeights,
    place: [f64; 2],
    is_on_edge: bool,
    answer: &Answer,
) -> Option<(Option<String>, bool)> {
    let layout = &truth.layout;
    let [across, along] = layout.cells();
    let [(column, u), (row, v)] = [(place[0], across), (place[1], along)].map(|(share, cells)| {
        let at = share * cells as f64;
        let cell = (at as usize).min(cells - 1);
        (cell, at - cell as f64)
    });
    let (u, v) = if is_on_edge { (0.0, if v < 0.5 { 0.0 } else { v }) } else { (u, v) };
    // Places near edges of triangles belong to two of them.
    let near_diagonal = match layout.diagonal {
        Diagonal::Rising => u - v,
        Diagonal::Falling => u + v - 1.0,
    };
    let is_near_edge = [u, v, 1.0 - u, 1.0 - v, near_diagonal.abs()].iter().any(|distance| *distance < 1e-6);
    if is_near_edge && !is_on_edge {
        return None;
    }
    let [z00, z10, z01, z11] = truth.corners(column, row);
    let expected = match (layout.diagonal, near_diagonal > 0.0) {
        (Diagonal::Rising, true) => z00 + u * (z10 - z00) + v * (z11 - z10),
        (Diagonal::Rising, false) => z00 + v * (z01 - z00) + u * (z11 - z01),
        (Diagonal::Falling, false) => z00 + u * (z10 - z00) + v * (z01 - z00),
        (Diagonal::Falling, true) => z11 + (1.0 - u) * (z01 - z11) + (1.0 - v) * (z10 - z11),
    };
    let is_hole = truth.is_hole(column, row);
    if is_hole && is_on_edge {
        // The cells beyond the edge decide.
        return None;
    }
    let between = |at: f64, low: f64, high: f64| low + at * (high - low);
    let x = between(u, layout.x(column), layout.x(column + 1));
    let y = between(v, layout.y(row), layout.y(row + 1));
    let [low, high] = field.bounds();
    let top = high.z + (high.z - low.z).max(layout.spacing[0]);
    let found = answer(&Ray::new(DVec3::new(x, y, top), DVec3::NEG_Z).ok()?);
    let problem = |text: String| Some((Some(format!("a ray at x {x}, y {y} {text}")), found.hit));
    if found.hit == is_hole {
        let what = if is_hole { "a hole" } else { "ground" };
        return problem(format!("{} where the samples have {what}", if found.hit { "hits" } else { "misses" }));
    }
    if found.status == Status::Touching {
        return problem("has no certain answer".to_owned());
    }
    let slack = ROUNDING * (low.abs().max(high.abs()).max_element() + (high - low).length())
        + 1e-9 * (z00 - z11).abs().max((z10 - z01).abs());
    let (below, above) = (top - found.t_upper, top - found.t_lower);
    if is_hole || below - slack <= expected && expected <= above + slack {
        return Some((None, found.hit));
    }
    problem(format!("hits at z {} where the samples have {expected}", top - found.t))
}

#[cfg(test)]
mod tests {
    use super::*;
    use hullmap_bake::height_field::{HeightGrid, bake_height_field, write_height_field};

    /// Only rays above samples and edges, whose x is a whole number, miss the ground.
    #[test]
    fn a_ray_through_an_edge_fails() {
        let layout = Layout { columns: 5, rows: 4, origin: [0.0; 2], spacing: [1.0; 2], diagonal: Diagonal::Rising };
        let heights: Vec<f32> = (0..20_u8).map(|index| f32::from(index * 7 % 5)).collect();
        let grid = HeightGrid { layout, heights: &heights, holes: &[], materials: &[] };
        let file = write_height_field(bake_height_field(&grid).unwrap(), &Default::default()).unwrap();
        let field = HeightField::from_bytes(&file).unwrap();
        let cast = |ray: &Ray| hullmap::ray(&field, ray, &CastSettings::default());
        let right = verify_answers(&field, None, 400, 1, &cast);
        assert!(right.pass && right.joint_rays == Some(200), "{right:?}");
        let miss = cast(&Ray::new(DVec3::splat(-1.0), DVec3::NEG_Z).unwrap());
        let wrong =
            verify_answers(&field, None, 400, 1, &|ray| if ray.origin().x.fract() == 0.0 { miss } else { cast(ray) });
        assert_eq!((wrong.pass, wrong.mismatches), (false, Some(200)), "{wrong:?}");
    }
}
