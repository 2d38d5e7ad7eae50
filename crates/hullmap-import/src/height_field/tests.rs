use super::*;

/// A PNG, its top row first.
fn image(width: u32, height: u32, color: png::ColorType, depth: png::BitDepth, data: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder.write_header().unwrap().write_image_data(data).unwrap();
    bytes
}

fn grey(width: u32, height: u32, samples: &[u16]) -> Vec<u8> {
    let data: Vec<u8> = samples.iter().flat_map(|sample| sample.to_be_bytes()).collect();
    image(width, height, png::ColorType::Grayscale, png::BitDepth::Sixteen, &data)
}

fn message(bytes: &[u8], options: &HeightOptions) -> String {
    import_heights("a", bytes, options).unwrap_err().to_string()
}

#[test]
fn images_count_from_black_to_white_and_their_top_row_is_the_last() {
    let options = HeightOptions { scale: 100.0, offset: -10.0, hole: Some(Hole::new(7.0)), ..HeightOptions::DEFAULT };
    let found = import_heights("a.png", &grey(3, 2, &[0, 65535, 7, 13107, 0, 0]), &options).unwrap();
    assert_eq!((found.columns, found.rows, found.is_image), (3, 2, true));
    assert_eq!(found.heights[..5], [10.0, -10.0, -10.0, -10.0, 90.0]);
    assert!(found.heights[5].is_nan());
    let eight = image(2, 1, png::ColorType::Grayscale, png::BitDepth::Eight, &[51, 255]);
    assert_eq!(import_heights("a", &eight, &options).unwrap().heights, [10.0, 90.0]);
    for hole in [256.0, -1.0, 0.5] {
        let found = message(&eight, &HeightOptions { hole: Some(Hole::new(hole)), ..options });
        assert!(found.contains(&format!("no sample is {hole}; name a grey value from 0 to 255")), "{found}");
    }
}

#[test]
fn images_of_other_kinds_have_a_remedy() {
    let options = HeightOptions::DEFAULT;
    let rgb = image(1, 1, png::ColorType::Rgb, png::BitDepth::Eight, &[1, 2, 3]);
    let text = message(&rgb, &options);
    assert!(text.starts_with("a: the image is colour of 8 bits; heights need greyscale of 16 bits"), "{text}");
    let bits = image(8, 1, png::ColorType::Grayscale, png::BitDepth::One, &[0xaa]);
    assert!(message(&bits, &options).contains("greyscale of 1 bits"));
    let mut cut = grey(64, 64, &[9; 64 * 64]);
    cut.truncate(cut.len() - 20);
    assert!(message(&cut, &options).contains("damaged PNG"));
    let mut bomb = grey(1, 1, &[1]);
    bomb[16..24].copy_from_slice(&[0, 0, 0x20, 0, 0, 0, 0x20, 0]);
    let crc = crc(&bomb[12..29]);
    bomb[29..33].copy_from_slice(&crc.to_be_bytes());
    let text = message(&bomb, &options);
    assert!(text.contains("cannot hold 8192 × 8192 samples"), "{text}");
}

/// CRC-32 of a chunk of a PNG, bit by bit.
fn crc(bytes: &[u8]) -> u32 {
    let step = |crc: u32, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 };
    !bytes.iter().fold(u32::MAX, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), step))
}

#[test]
fn raw_numbers_have_the_stated_size() {
    let bytes: Vec<u8> = [1.0_f32, -2.0, f32::NAN, 4.0, 5.0, -1.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let options =
        HeightOptions { raw: Some([2, 3]), scale: 2.0, hole: Some(Hole::new(-1.0)), ..HeightOptions::DEFAULT };
    let found = import_heights("a.f32", &bytes, &options).unwrap();
    assert_eq!((found.columns, found.rows, &found.heights[..2]), (2, 3, &[2.0, -4.0][..]));
    assert!(found.heights[2].is_nan() && found.heights[5].is_nan());
    let text = message(&bytes[..23], &options);
    assert!(text.contains("has 23 bytes, but 3 rows of 2 numbers of 32 bits take 24"), "{text}");
    let infinite = HeightOptions { scale: 1e39, ..options };
    assert!(message(&bytes, &infinite).contains("column 0, row 0 (counted from the least y) is infinite"));
    assert!(message(&bytes, &HeightOptions { raw: Some([usize::MAX, 2]), ..options }).contains("samples"));
    assert!(message(&bytes, &HeightOptions::DEFAULT).contains("expected a greyscale PNG"));
}

/// Values as tools write them, with samples as they are stored that are this value, and others.
#[test]
fn hole_values_match_samples_as_they_are_stored() {
    let same = |text: &str| text.parse::<f32>().unwrap();
    for (value, holes, others) in [
        ("-9999", vec![same("-9999")], vec![same("-9999.4"), same("-9998.999")]),
        ("-9999.9", vec![same("-9999.9")], vec![same("-9999.899")]),
        ("-9999.900390625", vec![same("-9999.9")], vec![-9000.0]),
        ("0.1", vec![0.1], vec![0.100_000_01, 0.0]),
        ("1e30", vec![1e30], vec![same("1.0000002e30")]),
        ("3.4028235e38", vec![f32::MAX], vec![f32::MAX.next_down().next_down(), f32::MIN]),
        ("-3.4e38", vec![-3.4e38], vec![f32::MIN, same("-3.4000003e38")]),
        // The least f32, rounded to six, seven and nine digits, and neighbours of the same digits.
        ("-3.40282e+38", vec![f32::MIN, same("-3.402820e38")], vec![-3.4028e38]),
        ("-3.402823e+38", vec![f32::MIN, f32::MIN.next_up()], vec![-3.4028e38, f32::MAX]),
        ("-3.40282347E+38", vec![f32::MIN], vec![f32::MIN.next_up().next_up(), -3.4e38]),
        ("-340282346638528859811704183484516925440", vec![f32::MIN], vec![f32::MIN.next_up()]),
        ("1.000000e+05", vec![1e5], vec![100_000.1]),
        ("100000", vec![1e5], vec![100_000.3]),
        ("0", vec![0.0, -0.0], vec![0.3, f32::MIN_POSITIVE]),
        ("0.000000e+00", vec![0.0], vec![1e-7]),
        ("-1.797693e+308", vec![], vec![f32::MIN]),
    ] {
        let hole: Hole = value.parse().unwrap();
        assert_eq!(hole.to_string().parse(), Ok(hole), "{value} reads back");
        let options = HeightOptions { hole: Some(hole), ..HeightOptions::DEFAULT };
        let samples: Vec<f32> = holes.iter().chain(&others).copied().chain([f32::NAN]).collect();
        let bytes: Vec<u8> = samples.iter().flat_map(|x| x.to_le_bytes()).collect();
        let raw = HeightOptions { raw: Some([samples.len(), 1]), ..options };
        let found = import_heights("a", &bytes, &raw).unwrap();
        let numbers = format!("ncols {}\nnrows 1\ncellsize 1\n", samples.len());
        let written = samples.iter().map(|x| f64::from(*x).to_string()).collect::<Vec<_>>().join(" ");
        let in_text = import_heights("a", (numbers.clone() + &written).as_bytes(), &options).unwrap();
        let stated = format!("{numbers}NODATA_value {value}\n{written}");
        let by_header = import_heights("a", stated.as_bytes(), &HeightOptions::DEFAULT).unwrap();
        for (heights, count) in [(&found, holes.len()), (&in_text, holes.len()), (&by_header, 0)] {
            let is_hole: Vec<bool> = heights.heights.iter().map(|height| height.is_nan()).collect();
            let (first, rest) = is_hole.split_at(holes.len());
            assert!(first.iter().all(|hole| *hole), "{value}: {heights:?}");
            assert!(rest[..others.len()].iter().all(|hole| !hole) && rest[others.len()], "{value}: {heights:?}");
            assert_eq!(heights.hole_samples, count, "{value}");
        }
    }
    let hole: Hole = "-1.797693e+308".parse().unwrap();
    assert!(hole.is_number(f64::MIN) && !hole.is_number(-1.7e308));
    assert!(["", "x", "1e400", "nan", "1e", "--1"].iter().all(|text| text.parse::<Hole>().is_err()));
    let none = HeightOptions { hole: Some(Hole::new(9.0)), ..HeightOptions::DEFAULT };
    assert_eq!(import_heights("a", &grey(2, 1, &[1, 2]), &none).unwrap().hole_samples, 0);
    assert_eq!(import_heights("a", &grey(2, 1, &[9, 9]), &none).unwrap().hole_samples, 2);
}

#[test]
fn grids_of_text_are_read() {
    let options = HeightOptions { hole: Some(Hole::new(5.0)), ..HeightOptions::DEFAULT };
    let head = "NCOLS 2\r\nnrows 2\nxllcenter -1.5\nyllcorner 4\ncellsize 0.5\nNODATA_value -1\n";
    let found = import_heights("a", format!("{head}1 2\n-1 5\n").as_bytes(), &options).unwrap();
    assert!(found.heights[0].is_nan() && found.heights[1].is_nan());
    assert_eq!(found.heights[2..], [1.0, 2.0]);
    assert_eq!((found.origin, found.spacing), (Some([-1.5, 4.25]), Some([0.5, 0.5])));
}

#[test]
fn holes_are_black_pixels_of_vertices_or_cells() {
    let vertices = grey(3, 3, &[9, 9, 9, 9, 9, 9, 9, 9, 0]);
    // The last pixel has the greatest x and the least y.
    assert_eq!(import_holes("h", &vertices, 3, 3).unwrap(), [false, true, false, false]);
    let cells = grey(2, 2, &[0, 9, 9, 9]);
    assert_eq!(import_holes("h", &cells, 3, 3).unwrap(), [false, false, true, false]);
    let text = import_holes("h", &cells, 4, 4).unwrap_err().to_string();
    assert_eq!(
        text,
        "h: the image has 2 × 2 pixels; expected 4 × 4 for the vertices of the height field, or 3 × 3 for its cells"
    );
    assert!(import_holes("h", b"P5", 4, 4).unwrap_err().to_string().contains("greyscale PNG"));
}

/// Every file with a flipped bit, or cut off, ends in heights of the right number or in an error of
/// one line that names the file.
#[test]
fn damaged_files_end_in_heights_or_an_error() {
    let grid = b"ncols 3\nnrows 2\nxllcorner 1e3\nyllcorner -2\ncellsize 5\nnodata_value -1\n1 2 3\n4 -1 6\n".to_vec();
    let eight = image(5, 4, png::ColorType::Grayscale, png::BitDepth::Eight, &[7; 20]);
    let raw: Vec<u8> = (0..6).flat_map(|i| (i as f32).to_le_bytes()).collect();
    let (mut read, mut rejected) = (0, 0);
    for (bytes, raw) in
        [(grid, None), (eight, None), (grey(3, 3, &[5, 0, 65535, 9, 9, 9, 1, 2, 3]), None), (raw, Some([3, 2]))]
    {
        let options = HeightOptions { raw, hole: Some(Hole::new(5.0)), ..HeightOptions::DEFAULT };
        let mut try_out = |bytes: &[u8]| {
            match import_heights("a", bytes, &options) {
                Ok(found) => {
                    read += 1;
                    assert_eq!(found.heights.len(), found.columns * found.rows);
                    assert!(found.heights.len() <= 1100 * bytes.len());
                }
                Err(error) => {
                    rejected += 1;
                    let text = error.to_string();
                    assert!(text.starts_with("a:") && !text.contains('\n'), "{text}");
                }
            }
            let _ = import_holes("a", bytes, 3, 3);
        };
        for bit in 0..8 * bytes.len() {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            try_out(&damaged);
        }
        (0..bytes.len()).for_each(|len| try_out(&bytes[..len]));
    }
    println!("{read} read, {rejected} rejected");
    assert!(read > 200 && rejected > 500, "{read} {rejected}");
}
