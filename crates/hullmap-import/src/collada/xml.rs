//! Elements, numbers and references of an XML document, and faults with their lines.

use roxmltree::Node;

use crate::fault::{Fault, LineFault, excerpt};

pub fn child<'a, 'input>(node: Node<'a, 'input>, name: &str) -> Option<Node<'a, 'input>> {
    node.children().find(|child| child.is_element() && child.tag_name().name() == name)
}

pub fn fault_at(node: Node, text: impl Into<String>) -> LineFault {
    let line = node.document().text_pos_at(node.range().start).row;
    Fault::format(text).at_line(line as usize)
}

pub fn number(node: Node, word: &str) -> Result<f64, LineFault> {
    let number = word.parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| fault_at(node, format!("`{}` is not a finite number: export the file again", excerpt(word))))
}

/// The id that a local reference names, `#id`.
pub fn local<'a>(node: Node<'a, '_>, attribute: &str) -> Result<&'a str, LineFault> {
    let written = node.attribute(attribute).unwrap_or_default();
    written.strip_prefix('#').ok_or_else(|| {
        let written = excerpt(written);
        fault_at(
            node,
            format!("`{attribute}` is `{written}`, which does not name a part of this file: export one file"),
        )
    })
}
