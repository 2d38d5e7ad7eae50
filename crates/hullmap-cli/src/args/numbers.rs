/// A count of at least 1.
pub fn at_least_one(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|&count| count >= 1).ok_or_else(|| "expected a whole number of at least 1".to_owned())
}

/// A number of bytes: `4096`, `500K`, `500M`, `8G`; K, M, G and T are powers of 1024.
pub fn size(text: &str) -> Result<u64, String> {
    let units = [("", 1_u64), ("K", 1 << 10), ("M", 1 << 20), ("G", 1 << 30), ("T", 1 << 40)];
    let digits = text.trim_end_matches(|letter: char| !letter.is_ascii_digit());
    let unit = text[digits.len()..].to_uppercase();
    let unit = unit.strip_suffix("IB").or(unit.strip_suffix('B')).unwrap_or(&unit);
    let factor = units.iter().find_map(|(name, factor)| (*name == unit).then_some(*factor));
    let bytes = digits.parse::<u64>().ok().zip(factor).and_then(|(number, factor)| number.checked_mul(factor));
    bytes.filter(|&bytes| bytes > 0).ok_or_else(|| "expected a size above 0, such as 500M or 8G".to_owned())
}
