//! Triangle meshes and height fields as shapes: baked surfaces, and parry's own of the same
//! triangles.

use std::sync::Arc;

use hullmap::height_field::{Diagonal, Layout};
use hullmap_parry::BakedSurface;
use hullmap_testkit::packs;
use rapier3d::prelude::*;

use super::way::Way;

/// A baked triangle mesh. Panics if it cannot be baked.
pub fn mesh(positions: &[[f32; 3]], corners: &[[u32; 3]]) -> BakedSurface {
    BakedSurface::new(Arc::new(packs::triangle_mesh(positions, corners)))
}

/// A height field of squares, in its own frame: heights are along z.
#[derive(Clone, Debug)]
pub struct Heights {
    /// The grid.
    pub layout: Layout,
    /// Heights, row by row.
    pub heights: Vec<f32>,
}

impl Heights {
    /// `columns` × `rows` cells, the first of which begins at `origin`.
    pub fn new(
        cells: [usize; 2],
        origin: [f64; 2],
        spacing: [f64; 2],
        diagonal: Diagonal,
        mut height: impl FnMut(f64, f64) -> f32,
    ) -> Self {
        let [columns, rows] = cells.map(|count| count + 1);
        let layout = Layout { columns, rows, origin, spacing, diagonal };
        let place = |i: usize| (layout.x(i % columns), layout.y(i / columns));
        let heights = (0..columns * rows).map(place).map(|(x, y)| height(x, y)).collect();
        Self { layout, heights }
    }

    /// The baked field, with y up. Panics if it cannot be baked.
    pub fn surface(&self) -> BakedSurface {
        let field = packs::height_field(self.layout, &self.heights, &[]);
        let y_up = Pose::new(Vector::ZERO, Vector::X * -std::f32::consts::FRAC_PI_2);
        BakedSurface::joined([(y_up, BakedSurface::new(Arc::new(field)))]).expect("one tile")
    }

    /// parry's field of the same heights, with y up and the other diagonal, and its pose.
    pub fn of_parry(&self) -> (Pose, SharedShape) {
        let Layout { columns, rows, .. } = self.layout;
        // parry's rows are along z, which is −y here, and its field is centred.
        let height = |row: usize, column: usize| self.heights[(rows - 1 - row) * columns + column];
        let mut heights = rapier3d::parry::utils::Array2::repeat(rows, columns, 0.0);
        for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
            heights[(row, column)] = height(row, column);
        }
        let [low, high] =
            [(0, 0), (columns - 1, rows - 1)].map(|(column, row)| [self.layout.x(column), self.layout.y(row)]);
        let size = Vector::new((high[0] - low[0]) as f32, 1.0, (high[1] - low[1]) as f32);
        let center = Vector::new((0.5 * (low[0] + high[0])) as f32, 0.0, (-0.5 * (low[1] + high[1])) as f32);
        (Pose::from_translation(center), SharedShape::heightfield(heights, size))
    }
}

/// A surface for a way of using shapes: parry's own triangle mesh of the same triangles, or the
/// surface. Panics if parry rejects the triangles.
pub fn shape(surface: &BakedSurface, way: Way) -> SharedShape {
    match way {
        Way::Parry => {
            let (vertices, triangles) = surface.to_trimesh();
            // Vertices at the same place are one, as in the baked mesh.
            let flags = TriMeshFlags::MERGE_DUPLICATE_VERTICES;
            SharedShape::trimesh_with_flags(vertices, triangles, flags).expect("parry takes the triangles")
        }
        Way::Shapes | Way::Dispatcher => surface.clone().into(),
    }
}
