//! A small still picture of a mesh inside its hull, rendered in software, for the folder's page and
//! for browsers without WebGL.
//!
//! Triangles are rasterised with a depth buffer, in an orthographic view from a corner, into a PNG
//! with a palette on a transparent background, at twice its display size.

use crate::DisplayMesh;
use crate::encode::base64;
use crate::input::Up;
use crate::part_colours::{COLOURS as PART_COLOURS, COUNT as COLOUR_COUNT};

/// Size in pixels; twice the display size.
pub const SIZE: [usize; 2] = [320, 240];

const SHADES: usize = 12;

/// Margin on each side, relative to width or height.
const MARGIN: f64 = 0.06;

/// Axes of the view: right, up and towards the viewer, rotated by −35° about z and tilted 25° down.
/// Constants, because the last digits of sines differ between machines.
const VIEW: [[f64; 3]; 3] = [
    [0.819_152_044_289, -0.573_576_436_351, 0.0],
    [0.242_403_876_506, 0.346_188_613_059, 0.906_307_787_037],
    [-0.519_836_790_726, -0.742_403_876_506, 0.422_618_261_741],
];

/// Axes of the view of a level: tilted 60° down.
const FROM_ABOVE: [[f64; 3]; 3] = [
    [0.819_152_044_289, -0.573_576_436_351, 0.0],
    [0.496_731_764_892, 0.709_406_479_866, 0.5],
    [-0.286_788_218_176, -0.409_576_022_145, 0.866_025_403_784],
];

/// Direction to the light, in the axes of the view.
const LIGHT: [f64; 3] = [-0.36, 0.6, 0.71];

/// The darkest and lightest shade of hulls, then of meshes.
const COLOURS: [[[u8; 3]; 2]; 2] = [[[60, 96, 150], [150, 190, 240]], [[92, 74, 52], [244, 212, 164]]];

/// The darkest shade of a part's colour, relative to the colour, which is the lightest.
const PART_DARKEST: f64 = 0.5;

/// Radius of a dot, in pixels.
const DOT: f64 = 1.5;

/// Opacity of hulls, of 255.
const HULL_ALPHA: u8 = 150;

/// The picture as a `data:` URL: the hulls behind, the meshes in front.
pub fn picture(hulls: &[DisplayMesh], meshes: &[DisplayMesh], up: Up) -> String {
    let layer = |layer: usize| move |shape| (shape, layer);
    let layers = [hulls.iter().map(layer(0)).collect(), meshes.iter().map(layer(1)).collect()];
    two_colours(&draw(&layers, up, VIEW))
}

/// The picture of a level, as a `data:` URL.
pub fn picture_from_above(mesh: &DisplayMesh, up: Up) -> String {
    two_colours(&draw(&[vec![(mesh, 1)]], up, FROM_ABOVE))
}

fn two_colours(pixels: &[u8]) -> String {
    format!("data:image/png;base64,{}", base64(&png(pixels, &COLOURS, HULL_ALPHA)))
}

/// Picture as a `data:` URL. Parts beyond the `colours` take these in turn.
pub fn picture_of_parts(parts: &[DisplayMesh], colours: &[usize], up: Up) -> String {
    let colour = |index: usize| colours.get(index).copied().unwrap_or(index % COLOUR_COUNT);
    let layer = parts.iter().enumerate().map(|(index, part)| (part, colour(index)));
    let pixels = draw(&[layer.collect()], up, VIEW);
    let shades = PART_COLOURS.map(|light| [light.map(|c| (f64::from(c) * PART_DARKEST) as u8), light]);
    format!("data:image/png;base64,{}", base64(&png(&pixels, &shades, u8::MAX)))
}

/// The pixels of shapes, each with its colour. A group of shapes is in front of earlier groups.
fn draw(groups: &[Vec<(&DisplayMesh, usize)>], up: Up, view: [[f64; 3]; 3]) -> Vec<u8> {
    let seen = |[x, y, z]: [f32; 3]| {
        let point = if up == Up::Z { [x, y, z] } else { [x, -z, y] };
        view.map(|axis| (0..3).map(|i| axis[i] * f64::from(point[i])).sum::<f64>())
    };
    let all = || groups.iter().flatten().map(|(shape, _)| *shape);
    let mut low = [f64::INFINITY; 2];
    let mut high = [f64::NEG_INFINITY; 2];
    for point in all().flat_map(|shape| &shape.points) {
        let [x, y, _] = seen(*point);
        for (axis, c) in [x, y].into_iter().enumerate() {
            (low[axis], high[axis]) = (low[axis].min(c), high[axis].max(c));
        }
    }
    let room = SIZE.map(|pixels| pixels as f64 * (1.0 - 2.0 * MARGIN));
    let scale = [0, 1].map(|axis| room[axis] / (high[axis] - low[axis])).into_iter().fold(f64::INFINITY, f64::min);
    // A point has no size: any scale will do.
    let scale = if scale.is_finite() { scale } else { 1.0 };
    let place = |point: [f32; 3]| {
        let [x, y, z] = seen(point);
        let middle = [0, 1].map(|axis| (low[axis] + high[axis]) / 2.0);
        let [width, height] = SIZE.map(|pixels| pixels as f64 / 2.0);
        [width + (x - middle[0]) * scale, height - (y - middle[1]) * scale, z * scale]
    };

    let mut pixels = vec![0_u8; SIZE[0] * SIZE[1]];
    for shapes in groups {
        let mut depths = vec![f64::NEG_INFINITY; pixels.len()];
        for &(shape, layer) in shapes {
            for triangle in &shape.triangles {
                let corners = triangle.map(|corner| place(shape.points[corner as usize]));
                fill(&mut pixels, &mut depths, corners, layer);
            }
            // A mesh without triangles is drawn as dots, its edges as rows of dots.
            if shape.triangles.is_empty() {
                let is_alone = shape.points.len() == 1;
                for &[from, to] in &shape.edges {
                    let [from, to] = [from, to].map(|corner| place(shape.points[corner as usize]));
                    for step in 0..=SIZE[0] {
                        let along = step as f64 / SIZE[0] as f64;
                        dot(&mut pixels, [0, 1].map(|i| from[i] + (to[i] - from[i]) * along), DOT, layer);
                    }
                }
                let radius = if is_alone { 8.0 } else { DOT };
                shape
                    .points
                    .iter()
                    .for_each(|&point| dot(&mut pixels, [place(point)[0], place(point)[1]], radius, layer));
            }
        }
    }
    pixels
}

fn colour(layer: usize, shade: f64) -> u8 {
    (1 + layer * SHADES) as u8 + (shade.clamp(0.0, 1.0) * (SHADES - 1) as f64).round() as u8
}

fn fill(pixels: &mut [u8], depths: &mut [f64], [a, b, c]: [[f64; 3]; 3], layer: usize) {
    let cross = |p: [f64; 3], q: [f64; 3], x: f64, y: f64| (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]);
    let area = cross(a, b, c[0], c[1]);
    let [u, v] = [b, c].map(|p| [p[0] - a[0], a[1] - p[1], p[2] - a[2]]);
    let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let length = normal.iter().map(|c| c * c).sum::<f64>().sqrt();
    // NaN takes the failing branch.
    if !(area != 0.0 && length > 0.0) {
        return;
    }
    // Meshes may be wound either way: the visible side is lit.
    let lit = (0..3).map(|i| normal[i] * LIGHT[i]).sum::<f64>() / length * normal[2].signum();
    let colour = colour(layer, 0.25 + 0.75 * lit);
    let range = |axis: usize| {
        let of = [a, b, c].map(|corner| corner[axis]);
        let low = of.into_iter().fold(f64::INFINITY, f64::min).floor();
        let high = of.into_iter().fold(f64::NEG_INFINITY, f64::max).ceil();
        // Casts saturate at zero.
        low as usize..=(high as usize).min(SIZE[axis] - 1)
    };
    for row in range(1) {
        for column in range(0) {
            let (x, y) = (column as f64 + 0.5, row as f64 + 0.5);
            let weights = [cross(b, c, x, y) / area, cross(c, a, x, y) / area, cross(a, b, x, y) / area];
            if weights.iter().all(|&weight| weight >= 0.0) {
                let depth = weights[0] * a[2] + weights[1] * b[2] + weights[2] * c[2];
                let at = row * SIZE[0] + column;
                if depth > depths[at] {
                    (depths[at], pixels[at]) = (depth, colour);
                }
            }
        }
    }
}

fn dot(pixels: &mut [u8], [x, y]: [f64; 2], radius: f64, layer: usize) {
    let reach = radius.ceil() as i32;
    for (dx, dy) in (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (f64::from(dx), f64::from(dy)))) {
        let (column, row) = ((x + dx) as usize, (y + dy) as usize);
        if dx * dx + dy * dy <= radius * radius && column < SIZE[0] && row < SIZE[1] {
            pixels[row * SIZE[0] + column] = colour(layer, 0.7);
        }
    }
}

/// Palette: 0 is transparent, then the shades of each colour. The first colour has an opacity.
fn png(pixels: &[u8], colours: &[[[u8; 3]; 2]], first_alpha: u8) -> Vec<u8> {
    let (mut palette, mut alpha) = (vec![0; 3], vec![0]);
    for (layer, [dark, light]) in colours.iter().enumerate() {
        for shade in 0..SHADES {
            let blend = |i: usize| {
                let (dark, light) = (usize::from(dark[i]), usize::from(light[i]));
                ((dark * (SHADES - 1 - shade) + light * shade) / (SHADES - 1)) as u8
            };
            palette.extend([0, 1, 2].map(blend));
            alpha.push(if layer == 0 { first_alpha } else { u8::MAX });
        }
    }
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, SIZE[0] as u32, SIZE[1] as u32);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(palette);
    encoder.set_trns(alpha);
    // Neighbouring pixels have unrelated palette indices, so filters do not help.
    encoder.set_filter(png::Filter::NoFilter);
    encoder.set_compression(png::Compression::High);
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(pixels));
    written.expect("writing to memory succeeds, and there is a byte a pixel");
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> DisplayMesh {
        let points = vec![[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
        DisplayMesh { points, triangles: vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], ..DisplayMesh::default() }
    }

    fn pixels(picture: &str) -> Vec<u8> {
        use base64::{Engine, engine::general_purpose::STANDARD};
        let bytes = STANDARD.decode(picture.strip_prefix("data:image/png;base64,").unwrap()).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut pixels = vec![0; SIZE[0] * SIZE[1]];
        reader.next_frame(&mut pixels).unwrap();
        pixels
    }

    #[test]
    fn pictures_show_hull_and_mesh() {
        let mut small = tetrahedron();
        small.points.iter_mut().flatten().for_each(|c| *c *= 0.5);
        let drawn = pixels(&picture(&[tetrahedron()], &[small], Up::Z));
        let share = |from: usize, to: usize| {
            drawn.iter().filter(|&&pixel| (from..to).contains(&usize::from(pixel))).count() as f64 / drawn.len() as f64
        };
        let (nothing, hull, mesh) = (share(0, 1), share(1, 1 + SHADES), share(1 + SHADES, 1 + 2 * SHADES));
        assert!(nothing > 0.3 && hull > 0.1 && mesh > 0.03, "{nothing} {hull} {mesh}");
        let mut large = tetrahedron();
        large.points.iter_mut().flatten().for_each(|c| *c *= 1024.0);
        assert_eq!(picture(&[large], &[], Up::Z), picture(&[tetrahedron()], &[], Up::Z));
    }

    #[test]
    fn parts_have_colours_of_their_own() {
        let parts: Vec<DisplayMesh> = (0..PART_COLOURS.len() + 1)
            .map(|part| {
                let mut part_mesh = tetrahedron();
                part_mesh.points.iter_mut().for_each(|point| point[0] += 3.0 * part as f32);
                part_mesh
            })
            .collect();
        let drawn = pixels(&picture_of_parts(&parts, &[], Up::Z));
        for layer in 0..PART_COLOURS.len() {
            let shades = 1 + layer * SHADES..1 + (layer + 1) * SHADES;
            let count = drawn.iter().filter(|&&pixel| shades.contains(&usize::from(pixel))).count();
            assert!(count > 50, "colour {layer}: {count} pixels");
        }
    }

    #[test]
    fn either_axis_points_up() {
        let mut lying = tetrahedron();
        lying.points.iter_mut().for_each(|point| point[2] *= 3.0);
        let mut turned = lying.clone();
        turned.points.iter_mut().for_each(|point| *point = [point[0], point[2], -point[1]]);
        assert_eq!(picture(&[lying.clone()], &[], Up::Z), picture(&[turned], &[], Up::Y));
        assert_ne!(picture(&[lying.clone()], &[], Up::Z), picture(&[lying], &[], Up::Y));
    }

    #[test]
    fn points_and_segments_are_drawn() {
        let point = DisplayMesh { points: vec![[1.0, 2.0, 3.0]], ..DisplayMesh::default() };
        let edges = vec![[0, 1]];
        let segment = DisplayMesh { points: vec![[0.0; 3], [1.0, 0.0, 0.0]], edges, ..DisplayMesh::default() };
        let empty = DisplayMesh::default();
        for (shape, least) in [(point, 5), (segment, 200), (empty, 0)] {
            let drawn = pixels(&picture(&[shape], &[], Up::Z)).iter().filter(|&&pixel| pixel > 0).count();
            assert!(drawn >= least && drawn < 4_000, "{drawn}");
        }
    }

    #[test]
    fn views_are_rotations() {
        for view in [VIEW, FROM_ABOVE] {
            for (i, a) in view.iter().enumerate() {
                for (j, b) in view.iter().enumerate() {
                    let dot: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
                    assert!((dot - f64::from(u8::from(i == j))).abs() < 1e-8);
                }
            }
            assert!(glam::DVec3::from(view[0]).cross(view[1].into()).dot(view[2].into()) > 0.999);
        }
    }

    #[test]
    fn levels_are_seen_from_above() {
        let points = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let ground = DisplayMesh { points, triangles: vec![[0, 1, 2], [0, 2, 3]], ..DisplayMesh::default() };
        let drawn = |picture: &str| pixels(picture).iter().filter(|&&pixel| pixel > 0).count();
        let [above, beside] = [picture_from_above(&ground, Up::Z), picture(&[], &[ground], Up::Z)].map(|p| drawn(&p));
        assert!(above as f64 > 1.5 * beside as f64, "{above} {beside}");
    }
}
