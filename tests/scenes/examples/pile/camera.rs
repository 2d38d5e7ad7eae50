//! Images of the pit: triangles with flat shading and a depth buffer, on the processor.
//!
//! Own code in place of a library: euc, the software renderer for Rust, had its last release in
//! 2021, and GPU renderers need a GPU. The job is one function over triangles.

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::PathBuf;

use hullmap_scenes::pit::Pit;
use rapier3d::prelude::*;

/// Size of an image in pixels.
const SIZE: [usize; 2] = [960, 540];

/// Samples of a pixel along each axis.
const SAMPLES: usize = 2;

/// Cotangent of half the angle of view, upright.
const FOCAL_LENGTH: f32 = 2.9;

/// Triangles closer to the camera than this are not drawn.
const NEAREST: f32 = 0.1;

const SKY: [f32; 3] = [0.93, 0.94, 0.96];
const FLOOR: [f32; 3] = [0.78, 0.79, 0.80];
const ASLEEP: [f32; 3] = [0.62, 0.63, 0.65];

/// Colours of bodies that move.
const AWAKE: [[f32; 3]; 4] = [[0.86, 0.42, 0.25], [0.22, 0.52, 0.74], [0.90, 0.68, 0.20], [0.33, 0.62, 0.40]];

/// A camera that looks into the pit, and writes its images to a folder.
pub struct Camera {
    folder: PathBuf,
    position: Vector,
    /// Rightwards, upwards and forwards, of unit length.
    axes: [Vector; 3],
    light: Vector,
}

/// An image under way, with the depth of each sample.
struct Image {
    colours: Vec<[f32; 3]>,
    /// Reciprocal distances along the view: 0 is infinitely far.
    nearness: Vec<f32>,
}

impl Camera {
    /// A camera for this pit. The folder is created. Fails if the folder cannot be created.
    pub fn new(folder: PathBuf, pit: &Pit<'_>) -> io::Result<Self> {
        std::fs::create_dir_all(&folder)?;
        // Fewer bodies make a lower pile.
        let height = 0.8 + pit.bodies.len() as f32 / 500.0;
        let (position, target) = (Vector::new(9.0, 11.0 + height, 22.0), Vector::new(0.0, height, 0.0));
        let forwards = (target - position).normalize();
        let rightwards = forwards.cross(Vector::Y).normalize();
        let axes = [rightwards, rightwards.cross(forwards), forwards];
        Ok(Self { folder, position, axes, light: Vector::new(0.4, 0.8, 0.45).normalize() })
    }

    /// Writes image number `frame` of the pit. Fails if the file cannot be written.
    pub fn shoot(&self, pit: &Pit<'_>, frame: usize) -> Result<(), Box<dyn std::error::Error>> {
        let samples = SIZE[0] * SIZE[1] * SAMPLES * SAMPLES;
        let mut image = Image { colours: vec![SKY; samples], nearness: vec![0.0; samples] };
        let corner = |x: f32, z: f32| Vector::new(x, 0.0, z) * pit.half_width;
        let [a, b, c, d] = [corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
        self.draw(&mut image, [a, b, c], FLOOR);
        self.draw(&mut image, [a, c, d], FLOOR);
        for (i, (handle, model)) in pit.bodies.iter().enumerate() {
            let body = &pit.world.bodies[*handle];
            let colour = if body.is_sleeping() { ASLEEP } else { AWAKE[(i + i / 8) % AWAKE.len()] };
            let hull = model.hull.hull();
            let vertices: Vec<Vector> = hull.vertices().map(|v| *body.position() * v).collect();
            for face in hull.faces() {
                // As a fan of triangles.
                let corners: Vec<Vector> = face.map(|v| vertices[v as usize]).collect();
                corners
                    .windows(2)
                    .skip(1)
                    .for_each(|pair| self.draw(&mut image, [corners[0], pair[0], pair[1]], colour));
            }
        }
        let file = BufWriter::new(File::create(self.folder.join(format!("{frame:04}.png")))?);
        let mut encoder = png::Encoder::new(file, SIZE[0] as u32, SIZE[1] as u32);
        encoder.set_color(png::ColorType::Rgb);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&image.pixels())?;
        writer.finish()?;
        Ok(())
    }

    /// Draws a triangle if it faces the camera.
    fn draw(&self, image: &mut Image, corners: [Vector; 3], colour: [f32; 3]) {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        if normal.dot(corners[0] - self.position) >= 0.0 {
            return;
        }
        let seen = corners.map(|corner| {
            let [x, y, distance] = self.axes.map(|axis| axis.dot(corner - self.position));
            [x, y, distance]
        });
        if seen.iter().any(|[_, _, distance]| *distance < NEAREST) {
            return;
        }
        let brightness = 0.35 + 0.65 * (0.5 + 0.5 * normal.normalize_or_zero().dot(self.light)).powf(1.5);
        let colour = colour.map(|c| c * brightness);
        let [width, height] = SIZE.map(|size| (size * SAMPLES) as f32);
        let at = seen.map(|[x, y, distance]| {
            let scale = FOCAL_LENGTH * 0.5 * height / distance;
            [0.5 * width + x * scale, 0.5 * height - y * scale, 1.0 / distance]
        });
        image.fill(at, colour);
    }
}

impl Image {
    /// Fills a triangle. Corners are in samples from the upper left, with their nearness, which is
    /// linear across the triangle.
    fn fill(&mut self, [a, b, c]: [[f32; 3]; 3], colour: [f32; 3]) {
        let [width, height] = SIZE.map(|size| size * SAMPLES);
        let cross = |p: [f32; 3], q: [f32; 3], x: f32, y: f32| (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]);
        let area = cross(a, b, c[0], c[1]);
        if area == 0.0 {
            return;
        }
        // A cast from a negative float is 0.
        let range = |k: usize, limit: usize| {
            let low = a[k].min(b[k]).min(c[k]).floor() as usize;
            let high = a[k].max(b[k]).max(c[k]).ceil() as usize;
            low..high.min(limit)
        };
        for row in range(1, height) {
            for column in range(0, width) {
                let (x, y) = (column as f32 + 0.5, row as f32 + 0.5);
                let weights = [cross(b, c, x, y), cross(c, a, x, y), cross(a, b, x, y)].map(|w| w / area);
                if weights.iter().any(|w| *w < 0.0) {
                    continue;
                }
                let nearness = weights[0] * a[2] + weights[1] * b[2] + weights[2] * c[2];
                let sample = row * width + column;
                if nearness > self.nearness[sample] {
                    (self.nearness[sample], self.colours[sample]) = (nearness, colour);
                }
            }
        }
    }

    /// The means of each pixel's samples, as bytes.
    fn pixels(&self) -> Vec<u8> {
        let [width, height] = SIZE;
        let mut pixels = Vec::with_capacity(width * height * 3);
        for (row, column) in (0..height).flat_map(|row| (0..width).map(move |column| (row, column))) {
            for channel in 0..3 {
                let mut sum = 0.0;
                for (down, right) in (0..SAMPLES).flat_map(|down| (0..SAMPLES).map(move |right| (down, right))) {
                    let sample = (row * SAMPLES + down) * width * SAMPLES + column * SAMPLES + right;
                    sum += self.colours[sample][channel];
                }
                pixels.push((sum / (SAMPLES * SAMPLES) as f32 * 255.0).round() as u8);
            }
        }
        pixels
    }
}
