//! Colours of parts: the same in the pictures and in the table of parts.
//!
//! Seven hues that readers with any colour vision can distinguish, in three lightnesses. Parts
//! whose boxes touch have different colours, while there are enough.
//!
//! # Reference
//! Okabe, Ito, "Color universal design", 2008, with a darker yellow for white pages.

use hullmap::glam::Vec3;

pub const COUNT: usize = 21;

/// The colours, the seven hues in the middle lightness first.
pub const COLOURS: [[u8; 3]; COUNT] = [
    [230, 159, 0],
    [0, 114, 178],
    [86, 180, 233],
    [213, 94, 0],
    [0, 158, 115],
    [204, 121, 167],
    [214, 198, 40],
    [246, 210, 136],
    [128, 150, 214],
    [176, 220, 244],
    [236, 168, 120],
    [120, 206, 182],
    [232, 188, 212],
    [246, 242, 180],
    [140, 96, 0],
    [0, 66, 106],
    [46, 108, 146],
    [130, 54, 0],
    [0, 92, 66],
    [128, 66, 102],
    [130, 120, 20],
];

/// Colour of each part, by the minimum and maximum of its box, in O(n²).
pub fn assigned(boxes: &[[Vec3; 2]]) -> Vec<usize> {
    let mut chosen: Vec<usize> = Vec::with_capacity(boxes.len());
    for (index, [low, high]) in boxes.iter().enumerate() {
        let mut is_taken = [false; COUNT];
        for (colour, [from, to]) in chosen.iter().zip(boxes) {
            if low.cmple(*to).all() && from.cmple(*high).all() {
                is_taken[*colour] = true;
            }
        }
        let first = index % COUNT;
        let free = (0..COUNT).map(|step| (first + step) % COUNT).find(|colour| !is_taken[*colour]);
        chosen.push(free.unwrap_or(first));
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    fn linear(colour: [u8; 3]) -> [f64; 3] {
        colour.map(|c| {
            let c = f64::from(c) / 255.0;
            if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        })
    }

    /// Björn Ottosson's perceptual space, in which distances are differences that people see.
    fn oklab(rgb: [f64; 3]) -> [f64; 3] {
        let dot = |row: [f64; 3], v: [f64; 3]| row.iter().zip(v).map(|(a, b)| a * b).sum::<f64>();
        let lms = [
            [0.412_221_470_8, 0.536_332_536_3, 0.051_445_992_9],
            [0.211_903_498_2, 0.680_699_545_1, 0.107_396_956_6],
            [0.088_302_461_9, 0.281_718_837_6, 0.629_978_700_5],
        ]
        .map(|row| dot(row, rgb).max(0.0).cbrt());
        [
            [0.210_454_255_3, 0.793_617_785, -0.004_072_046_8],
            [1.977_998_495_1, -2.428_592_205, 0.450_593_709_9],
            [0.025_904_037_1, 0.782_771_766_2, -0.808_675_766],
        ]
        .map(|row| dot(row, lms))
    }

    fn least_difference(colours: &[[u8; 3]], seen: [[f64; 3]; 3]) -> f64 {
        let apply = |rgb: [f64; 3]| seen.map(|row| row.iter().zip(rgb).map(|(a, b)| a * b).sum::<f64>());
        let labs: Vec<[f64; 3]> = colours.iter().map(|colour| oklab(apply(linear(*colour)))).collect();
        let mut least = f64::INFINITY;
        for (index, a) in labs.iter().enumerate() {
            for b in &labs[..index] {
                least = least.min(a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt());
            }
        }
        least
    }

    const NORMAL: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    /// Machado, Oliveira, Fernandes, "A physiologically-based model for simulation of color vision
    /// deficiency", 2009, at full severity.
    const DEFICIENT: [[[f64; 3]; 3]; 3] = [
        [[0.152_286, 1.052_583, -0.204_868], [0.114_503, 0.786_281, 0.099_216], [-0.003_882, -0.048_116, 1.051_998]],
        [[0.367_322, 0.860_646, -0.227_968], [0.280_085, 0.672_501, 0.047_413], [-0.011_820, 0.042_940, 0.968_881]],
        [[1.255_528, -0.076_749, -0.178_779], [-0.078_411, 0.930_809, 0.147_602], [0.004_733, 0.691_367, 0.303_900]],
    ];

    /// A difference of 0.02 is just visible side by side.
    #[test]
    fn readers_with_any_colour_vision_can_distinguish_the_hues() {
        for seen in [NORMAL].into_iter().chain(DEFICIENT) {
            let least = least_difference(&COLOURS[..7], seen);
            println!("{least}");
            assert!(least > 0.05, "{least}");
        }
        let least = least_difference(&COLOURS, NORMAL);
        assert!(least > 0.04, "{least}");
    }

    #[test]
    fn parts_that_touch_have_different_colours() {
        let row = |k: usize| [Vec3::new(k as f32, 0.0, 0.0), Vec3::new(k as f32 + 1.0, 1.0, 1.0)];
        let boxes: Vec<[Vec3; 2]> = (0..100).map(|k| row(k * 21 % 100)).collect();
        let chosen = assigned(&boxes);
        for (a, b) in (0..100).flat_map(|a| (0..a).map(move |b| (a, b))) {
            let is_beside = boxes[a][0].x - boxes[b][0].x;
            assert!(is_beside.abs() > 1.0 || chosen[a] != chosen[b], "{a} {b}");
        }
        assert_eq!(chosen, assigned(&boxes));
        assert!(assigned(&vec![row(0); 30]).iter().all(|colour| *colour < COUNT));
    }
}
