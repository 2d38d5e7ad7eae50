//! XML as robot programs read it: TinyXML accepts some texts that XML 1.0 does not allow.
//!
//! [`prepared`] replaces them for the parser by texts of the same length, so that spans stay valid.
//!
//! | accepted | replaced by |
//! |---|---|
//! | `--` inside a comment | spaces |
//! | an XML declaration that is not the first thing in the file | spaces |
//! | anything behind the root element, such as another end tag | spaces |
//! | a prefix without a namespace, as in `<sensor:camera>` | `_` for the colon |

use std::borrow::Cow;
use std::collections::BTreeSet;

/// Maximum depth of nested elements. Descriptions have fewer than 100.
pub const MAX_DEPTH: usize = 1000;

/// Elements are nested deeper than [`MAX_DEPTH`]; the place where.
#[derive(Debug, PartialEq, Eq)]
pub struct TooDeep(pub usize);

/// The text for the parser, of the same length, which reports other faults.
pub fn prepared(text: &str) -> Result<Cow<'_, str>, TooDeep> {
    let mut blank: Vec<std::ops::Range<usize>> = Vec::new();
    let bytes = text.as_bytes();
    let (mut at, mut depth) = (0, 0_usize);
    let mut root = None;
    let find = |from: usize, what: &str| text[from..].find(what).map_or(text.len(), |found| from + found);
    while let Some(next) = text[at..].find('<').map(|found| at + found) {
        let rest = &text[next..];
        if rest.starts_with("<!--") {
            let end = find(next + 4, "-->");
            blank.extend(text[next + 4..end].match_indices("--").map(|(found, _)| next + 4 + found..next + 6 + found));
            // A comment must not end in `--->`.
            if end > next + 4 && end < text.len() && bytes[end - 1] == b'-' {
                blank.push(end - 1..end);
            }
            at = (end + 3).min(text.len());
        } else if rest.starts_with("<![CDATA[") {
            at = (find(next, "]]>") + 3).min(text.len());
        } else if rest.starts_with("<?") {
            at = (find(next, "?>") + 2).min(text.len());
            let name = rest.strip_prefix("<?xml");
            let is_declaration = name.is_some_and(|rest| rest.starts_with(|c: char| c.is_whitespace()));
            if is_declaration && next > 0 {
                blank.push(next..at);
            }
        } else {
            let end = end_of_tag(bytes, next);
            let is_empty = text[..end].ends_with("/>") && !rest.starts_with("</");
            let closes = rest.starts_with("</") && depth == 1 || is_empty && depth == 0;
            if closes && !rest.starts_with("<!") {
                root.get_or_insert(end);
            }
            if rest.starts_with("</") {
                depth = depth.saturating_sub(1);
            } else if !rest.starts_with("<!") && !text[..end].ends_with("/>") {
                depth += 1;
                if depth > MAX_DEPTH {
                    return Err(TooDeep(next));
                }
            }
            at = end;
        }
    }
    blank.extend(root.filter(|end| !text[*end..].trim().is_empty()).map(|end| end..text.len()));
    Ok(if blank.is_empty() { Cow::Borrowed(text) } else { Cow::Owned(blanked(text, &blank)) })
}

/// The place after the `>` that ends a tag. `>` in quotes is skipped.
fn end_of_tag(bytes: &[u8], start: usize) -> usize {
    let mut quote = None;
    for (at, &byte) in bytes.iter().enumerate().skip(start) {
        match (quote, byte) {
            (None, b'>') => return at + 1,
            (None, b'"' | b'\'') => quote = Some(byte),
            (Some(open), byte) if byte == open => quote = None,
            _ => {}
        }
    }
    bytes.len()
}

/// The text with these places replaced by spaces; line ends stay.
fn blanked(text: &str, places: &[std::ops::Range<usize>]) -> String {
    let mut bytes = text.as_bytes().to_vec();
    for place in places {
        for byte in &mut bytes[place.clone()] {
            if !matches!(byte, b'\n' | b'\r') {
                *byte = b' ';
            }
        }
    }
    // The places hold ASCII, except declarations, which become ASCII as a whole.
    String::from_utf8(bytes).unwrap_or_else(|_| text.to_owned())
}

/// The text with `prefix:` replaced by `prefix_`, where an element or attribute may begin.
pub fn without_prefix(text: &str, prefix: &str) -> String {
    let marked = format!("{prefix}:");
    let places: BTreeSet<usize> = text
        .match_indices(&marked)
        .filter(|(at, _)| {
            matches!(text.as_bytes().get(at.wrapping_sub(1)), Some(b'<' | b'/' | b' ' | b'\t' | b'\n' | b'\r'))
        })
        .map(|(at, _)| at + prefix.len())
        .collect();
    text.char_indices().map(|(at, letter)| if places.contains(&at) { '_' } else { letter }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_tiny_xml_accepts_is_replaced_in_place() {
        for (text, expected) in [
            ("<a><!-- x -- y --></a>", "<a><!-- x    y --></a>"),
            ("<a><!------></a>", "<a><!--  --></a>"),
            ("<a><!-- x ---></a>", "<a><!-- x  --></a>"),
            ("\n<?xml version='1.0'?>\n<a/>", "\n                     \n<a/>"),
            ("<?xml version='1.0'?><a/>", "<?xml version='1.0'?><a/>"),
            ("<a><b/></a>\n</a>é", "<a><b/></a>\n      "),
            ("<a/><b>", "<a/>   "),
            ("<a b='<!-- -- -->'/>", "<a b='<!-- -- -->'/>"),
            ("<a><![CDATA[<!-- -- -->]]></a>", "<a><![CDATA[<!-- -- -->]]></a>"),
        ] {
            assert_eq!(prepared(text).unwrap(), expected);
            assert_eq!(text.len(), expected.len());
        }
        assert_eq!(without_prefix("<s:a s:b='s:c'></s:a>", "s"), "<s_a s_b='s:c'></s_a>");
    }

    #[test]
    fn unfinished_texts_end() {
        for text in ["<", "<!--", "<!-- --", "<![CDATA[", "<?", "<?xml", "<a b='", "<a", "</", "<!"] {
            let _ = prepared(text);
        }
    }

    #[test]
    fn depth_is_limited() {
        let nested = |depth: usize| "<a>".repeat(depth) + &"</a>".repeat(depth);
        assert!(prepared(&nested(MAX_DEPTH)).is_ok());
        assert_eq!(prepared(&nested(MAX_DEPTH + 1)), Err(TooDeep(3 * MAX_DEPTH)));
        assert!(prepared(&"<a/>".repeat(5000)).is_ok());
    }
}
