//! The shaded relief of a height field, lit from the upper left.

use hullmap::HeightField;

use crate::encode::base64;

/// Index of the colour of holes. The other indices are grey, from black to white.
const HOLE: u8 = 255;

const HOLE_COLOUR: [u8; 3] = [0xd0, 0x34, 0x2c];

/// Unit vector to the light: from the upper left, and from above.
const LIGHT: [f64; 3] = [-0.5, 0.5, std::f64::consts::FRAC_1_SQRT_2];

/// The relief as a `data:` URL of a PNG, at most `max` pixels wide and high. A pixel is a cell, or
/// one of many.
pub fn relief(field: &HeightField, max: usize) -> String {
    let [across, along] = field.layout().cells();
    let [width, height] = [across, along].map(|cells| cells.min(max));
    let cell = |pixel: usize, pixels: usize, cells: usize| (2 * pixel + 1) * cells / (2 * pixels);
    let mut pixels = Vec::with_capacity(width * height);
    for line in 0..height {
        // The top line has the greatest y.
        let row = cell(height - 1 - line, height, along);
        pixels.extend((0..width).map(|pixel| shade(field, cell(pixel, width, across), row)));
    }
    let mut palette: Vec<u8> = (0..HOLE).flat_map(|grey| [grey; 3]).collect();
    palette.extend(HOLE_COLOUR);
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width as u32, height as u32);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(palette);
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(&pixels));
    written.expect("a vector takes every byte, and the sizes agree");
    format!("data:image/png;base64,{}", base64(&bytes))
}

/// The grey of a cell, by the normals of its triangles.
fn shade(field: &HeightField, column: usize, row: usize) -> u8 {
    let first = 2 * field.layout().cell(column, row);
    let (Some(a), Some(b)) = (field.normal(first), field.normal(first + 1)) else { return HOLE };
    let [x, y, z] = ((a + b) * 0.5).to_array();
    let light = x * LIGHT[0] + y * LIGHT[1] + z * LIGHT[2];
    (light.clamp(0.0, 1.0) * f64::from(HOLE - 1)).round() as u8
}

#[cfg(test)]
mod tests {
    use hullmap::height_field::{Diagonal, Layout};
    use hullmap_bake::height_field::{HeightGrid, bake_height_field, write_height_field};

    use super::*;

    #[test]
    fn slopes_are_darker_and_holes_have_a_colour() {
        let diagonal = Diagonal::Rising;
        let layout = Layout { columns: 4, rows: 2, origin: [0.0; 2], spacing: [1.0; 2], diagonal };
        let heights = [0.0, 1.0, 1.0, f32::NAN, 0.0, 1.0, 1.0, 0.0];
        let grid = HeightGrid { layout, heights: &heights, holes: &[], materials: &[] };
        let file = write_height_field(bake_height_field(&grid).unwrap(), &Default::default()).unwrap();
        let field = HeightField::from_bytes(&file).unwrap();
        let pixels = [0, 1, 2].map(|column| shade(&field, column, 0));
        assert!(pixels[0] > pixels[1] && pixels[1] > 150 && pixels[2] == HOLE, "{pixels:?}");
        assert!(relief(&field, 8).starts_with("data:image/png;base64,"));
        assert_eq!(relief(&field, 1), relief(&field, 1));
    }
}
