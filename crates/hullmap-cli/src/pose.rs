//! Poses as text: `tx ty tz qx qy qz qw`, with spaces or commas between them.

use std::path::Path;

use glam::{DQuat, DVec3};
use hullmap::Pose;
use hullmap_import::open_regular;

use hullmap_pipeline::outcome::Failure;

/// The quaternion may have any length except zero; it is normalised.
pub fn parse_pose(text: &str) -> Result<Pose, String> {
    let mut numbers = [0.0; 7];
    let mut found = 0;
    let is_between = |letter: char| letter.is_whitespace() || letter == ',';
    for word in text.split(is_between).filter(|word| !word.is_empty()) {
        let number: f64 = word.parse().map_err(|_| format!("`{word}` is not a number"))?;
        if !number.is_finite() {
            return Err(format!("`{word}` is not finite"));
        }
        if let Some(entry) = numbers.get_mut(found) {
            *entry = number;
        }
        found += 1;
    }
    if found != numbers.len() {
        return Err(format!("{found} numbers, but a pose has 7: tx ty tz qx qy qz qw"));
    }
    let [tx, ty, tz, quaternion @ ..] = numbers;
    // Scaled first, so that the squares of tiny and huge quaternions stay in range.
    let greatest = quaternion.iter().fold(0.0_f64, |greatest, q| greatest.max(q.abs()));
    if greatest == 0.0 {
        return Err("the quaternion qx qy qz qw is zero; write 0 0 0 1 for no rotation".to_owned());
    }
    let rotation = DQuat::from_array(quaternion.map(|q| q / greatest));
    Pose::new(DVec3::new(tx, ty, tz), rotation).map_err(|error| error.to_string())
}

/// Skips blank lines, and comments after `#`. The error is `name:line: what is wrong`.
pub fn parse_pose_lines(name: &str, text: &str) -> Result<Vec<Pose>, Failure> {
    let mut poses = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or("").trim();
        if !line.is_empty() {
            let pose = parse_pose(line).map_err(|error| Failure::usage(format!("{name}:{}: {error}", number + 1)))?;
            poses.push(pose);
        }
    }
    Ok(poses)
}

/// `-` is standard input.
pub fn read_poses(path: &Path) -> Result<Vec<Pose>, Failure> {
    let (name, text) = if path == Path::new("-") {
        ("standard input".to_owned(), std::io::read_to_string(std::io::stdin().lock()))
    } else {
        (path.display().to_string(), open_regular(path).and_then(std::io::read_to_string))
    };
    let text = text.map_err(|error| {
        Failure::usage(format!("{name}: cannot read the poses: {error}; name a file, or `-` for standard input"))
    })?;
    let poses = parse_pose_lines(&name, text.trim_start_matches('\u{FEFF}'))?;
    if poses.is_empty() {
        return Err(Failure::usage(format!("{name}: no poses; expected one per line: tx ty tz qx qy qz qw")));
    }
    Ok(poses)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_is_seven_numbers() {
        let pose = parse_pose(" 1 -2\t3e0 0 0 0 1 ").unwrap();
        assert_eq!(pose, Pose::new(DVec3::new(1.0, -2.0, 3.0), DQuat::IDENTITY).unwrap());
        assert_eq!(parse_pose("1, -2,3e0\t0,0,0,1").unwrap(), pose);
        assert_eq!(parse_pose("0 0 0 0 0 0 1").unwrap(), Pose::IDENTITY);
    }

    #[test]
    fn quaternions_of_any_length_are_normalised() {
        for scale in ["2", "1e-300", "1e300", "5e-324"] {
            let pose = parse_pose(&format!("0 0 0 0 0 {scale} {scale}")).unwrap();
            let half = std::f64::consts::FRAC_1_SQRT_2;
            assert!((pose.rotation().z - half).abs() < 1e-15 && (pose.rotation().w - half).abs() < 1e-15, "{scale}");
        }
    }
}
