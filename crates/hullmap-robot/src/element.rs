//! Spans and edits of one XML element.

use std::collections::BTreeSet;
use std::ops::Range;

use roxmltree::Node;

use crate::edit::Edit;

/// The text of an attribute's value: special characters are escaped, forbidden ones replaced.
///
/// ```
/// assert_eq!(hullmap_robot::escaped("a<b>\n"), "a&lt;b&gt;_");
/// ```
pub fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '"' => escaped += "&quot;",
            '\'' => escaped += "&apos;",
            '\u{fffe}' | '\u{ffff}' => escaped.push('_'),
            letter if letter.is_control() => escaped.push('_'),
            letter => escaped.push(letter),
        }
    }
    escaped
}

pub fn child<'a, 'input>(node: Node<'a, 'input>, name: &str) -> Option<Node<'a, 'input>> {
    node.children().find(|child| child.is_element() && child.tag_name().name() == name)
}

pub fn children<'a, 'input>(node: Node<'a, 'input>, name: &'a str) -> impl Iterator<Item = Node<'a, 'input>> {
    node.children().filter(move |child| child.is_element() && child.tag_name().name() == name)
}

/// Sets an attribute: its value is replaced, or it is added behind the last one.
pub fn set(node: Node, text: &str, name: &str, value: &str) -> Edit {
    match node.attribute_node(name) {
        Some(attribute) => Edit::replace(attribute.range_value(), escaped(value)),
        None => {
            let at = node.attributes().next_back().map_or_else(|| name_span(node, text).end, |last| last.range().end);
            Edit::insert(at, format!(" {name}=\"{}\"", escaped(value)))
        }
    }
}

/// Removes an attribute, with the white space before it.
pub fn without(node: Node, text: &str, name: &str) -> Option<Edit> {
    let span = node.attribute_node(name)?.range();
    let start = text[..span.start].trim_end().len();
    Some(Edit::replace(start..span.end, ""))
}

pub fn name_span(node: Node, text: &str) -> Range<usize> {
    let start = node.range().start + 1;
    let len = text[start..].find(|c: char| c.is_whitespace() || matches!(c, '/' | '>')).unwrap_or_default();
    start..start + len
}

/// Renames an element: edits of its start tag and, if it has one, of its end tag.
pub fn rename(node: Node, text: &str, name: &str) -> Vec<Edit> {
    let open = name_span(node, text);
    let mut edits = vec![Edit::replace(open.clone(), name)];
    let element = &text[node.range()];
    if !element.ends_with("/>")
        && let Some(end) = element.rfind("</")
    {
        let start = node.range().start + end + 2;
        edits.push(Edit::replace(start..start + open.len(), name));
    }
    edits
}

/// The white space before an element: its line end and its indentation.
pub fn lead(node: Node, text: &str) -> Range<usize> {
    let start = node.range().start;
    let before = text[..start].trim_end_matches([' ', '\t', '\r', '\n']).len();
    // Only the last line end: blank lines belong to what is above.
    let line = text[before..start].rfind('\n').map_or(start, |at| before + at);
    let line = if line > before && text.as_bytes()[line - 1] == b'\r' { line - 1 } else { line };
    line..start
}

pub fn removed(node: Node, text: &str) -> Edit {
    Edit::replace(lead(node, text).start..node.range().end, "")
}

/// Returns the first of `name`, `name_2`, `name_3`, … that is not in `taken`, and adds it there.
pub fn unique(name: &str, taken: &mut BTreeSet<String>) -> String {
    let numbered = (2_u32..).map(|number| format!("{name}_{number}"));
    let free = std::iter::once(name.to_owned()).chain(numbered).find(|name| !taken.contains(name));
    let free = free.unwrap_or_else(|| name.to_owned());
    taken.insert(free.clone());
    free
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edit::edited;

    fn after(text: &str, edits: impl Fn(Node) -> Vec<Edit>) -> String {
        let document = roxmltree::Document::parse(text).unwrap();
        let node = document.root_element().first_element_child().unwrap();
        edited(text, 0..text.len(), edits(node))
    }

    #[test]
    fn attributes_are_set_added_and_removed() {
        for (text, expected) in [
            ("<r><a  x = 'old' y=\"1\"/></r>", "<r><a  x = 'n&quot;&apos;&lt;' y=\"1\"/></r>"),
            ("<r><a\n\ty='1' ></a></r>", "<r><a\n\ty='1' x=\"n&quot;&apos;&lt;\" ></a></r>"),
            ("<r><a/></r>", "<r><a x=\"n&quot;&apos;&lt;\"/></r>"),
            ("<r><a><b/></a></r>", "<r><a x=\"n&quot;&apos;&lt;\"><b/></a></r>"),
        ] {
            assert_eq!(after(text, |node| vec![set(node, text, "x", "n\"'<")]), expected);
        }
        let text = "<r><a y='1'\n  x = 'old' z=''/></r>";
        assert_eq!(after(text, |node| without(node, text, "x").into_iter().collect()), "<r><a y='1' z=''/></r>");
    }

    #[test]
    fn elements_are_renamed_and_removed() {
        for (text, expected) in [
            ("<r><a x='1'><b/></a ></r>", "<r><new x='1'><b/></new ></r>"),
            ("<r><a/></r>", "<r><new/></r>"),
            ("<r><a><a></a></a></r>", "<r><new><a></a></new></r>"),
        ] {
            assert_eq!(after(text, |node| rename(node, text, "new")), expected);
        }
        for (text, expected) in [
            ("<r>\n\n  <a/>\n</r>", "<r>\n\n</r>"),
            ("<r>\r\n  <a>\r\n</a>\r\n</r>", "<r>\r\n</r>"),
            ("<r>x <a/> y</r>", "<r>x  y</r>"),
        ] {
            assert_eq!(after(text, |node| vec![removed(node, text)]), expected);
        }
    }

    #[test]
    fn names_are_unique() {
        let mut taken = BTreeSet::from(["a".to_owned(), "a_2".to_owned()]);
        assert_eq!([unique("b", &mut taken), unique("a", &mut taken), unique("a", &mut taken)], ["b", "a_3", "a_4"]);
    }
}
