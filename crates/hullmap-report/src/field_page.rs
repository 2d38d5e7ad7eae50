//! The page of a height field: a shaded relief, and a table of facts.

use std::fmt::Write;

use hullmap::HeightField;

use crate::encode::base64;
use crate::html::escape;
use crate::page::Page;

const PAGE: Page = Page {
    kind: "field",
    generator: "bake report",
    style: ".relief { max-width: 100%; image-rendering: pixelated; border: 1px solid var(--rule); }\n",
    contents: include_str!("page/field.html"),
    scripts: &[],
};

const MAX_PIXELS: usize = 1024;

/// Index of the colour of holes. The other indices are grey, from black to white.
const HOLE: u8 = 255;

const HOLE_COLOUR: [u8; 3] = [0xd0, 0x34, 0x2c];

/// Unit vector to the light: from the upper left, and from above.
const LIGHT: [f64; 3] = [-0.5, 0.5, std::f64::consts::FRAC_1_SQRT_2];

/// The page of a height field. `facts` are rows of its table: a name and a value.
pub fn field_page(file: &str, field: &HeightField, facts: &[(String, String)]) -> String {
    let (relief, [width, height]) = relief(field);
    let mut rows = String::new();
    for (name, value) in facts {
        let _ = writeln!(rows, "<tr><th scope=\"row\">{}</th><td>{}</td></tr>", escape(name), escape(value));
    }
    let (width, height) = (width.to_string(), height.to_string());
    let values = [
        ("title", escape(file)),
        ("subtitle", format!("height field · {}", escape(field.options()))),
        ("relief", format!("data:image/png;base64,{}", base64(&relief))),
        ("width", width),
        ("height", height),
        ("facts", rows),
        ("footer", "bake report".to_owned()),
    ];
    PAGE.fill(&values.each_ref().map(|(name, value)| (*name, value.as_str())))
}

/// The shaded relief as a PNG, and its size. A pixel is a cell, or one of many.
fn relief(field: &HeightField) -> (Vec<u8>, [usize; 2]) {
    let [across, along] = field.layout().cells();
    let [width, height] = [across, along].map(|cells| cells.min(MAX_PIXELS));
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
    (bytes, [width, height])
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
    fn the_page_shows_slopes_and_holes() {
        let diagonal = Diagonal::Rising;
        let layout = Layout { columns: 4, rows: 2, origin: [0.0; 2], spacing: [1.0; 2], diagonal };
        let heights = [0.0, 1.0, 1.0, f32::NAN, 0.0, 1.0, 1.0, 0.0];
        let grid = HeightGrid { layout, heights: &heights, holes: &[], materials: &[] };
        let file = write_height_field(bake_height_field(&grid).unwrap(), &Default::default()).unwrap();
        let field = HeightField::from_bytes(&file).unwrap();
        let pixels = [0, 1, 2].map(|column| shade(&field, column, 0));
        assert!(pixels[0] > pixels[1] && pixels[1] > 150 && pixels[2] == HOLE, "{pixels:?}");
        let page = field_page("<a>", &field, &[("rows".to_owned(), "2".to_owned())]);
        assert!(page.contains("<title>&lt;a&gt;</title>") && page.contains("<th scope=\"row\">rows</th><td>2</td>"));
        assert!(
            page.contains("width=\"3\" height=\"1\"")
                && page == field_page("<a>", &field, &[("rows".into(), "2".into())])
        );
    }
}
