//! Edits of a text: spans that are replaced. Everything outside of them keeps its bytes.

use std::ops::Range;

/// Replacement of a span of a text; an empty span is an insertion.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edit {
    /// Bytes of the decoded text.
    pub span: Range<usize>,
    /// What replaces them.
    pub text: String,
}

impl Edit {
    /// Replaces a span.
    pub fn replace(span: Range<usize>, text: impl Into<String>) -> Self {
        Self { span, text: text.into() }
    }

    /// Inserts a text at a place.
    pub fn insert(at: usize, text: impl Into<String>) -> Self {
        Self { span: at..at, text: text.into() }
    }
}

/// The edits by their places. Insertions at one place keep their order.
///
/// # Panics
/// Two edits overlap: a fault of the planner.
pub fn in_order(mut edits: Vec<Edit>) -> Vec<Edit> {
    edits.sort_by_key(|edit| (edit.span.start, edit.span.end));
    for pair in edits.windows(2) {
        assert!(pair[0].span.end <= pair[1].span.start, "edits overlap: {pair:?}");
    }
    edits
}

/// The part `within` of a text, edited. All edits lie inside of it.
pub fn edited(text: &str, within: Range<usize>, edits: Vec<Edit>) -> String {
    let mut result = String::with_capacity(within.len());
    let mut at = within.start;
    for edit in in_order(edits) {
        result += &text[at..edit.span.start];
        result += &edit.text;
        at = edit.span.end;
    }
    result += &text[at..within.end];
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_are_applied_by_place() {
        let edits =
            vec![Edit::insert(5, "!"), Edit::replace(1..3, "_"), Edit::insert(5, "?"), Edit::replace(3..3, "=")];
        assert_eq!(edited("abcdef", 0..6, edits.clone()), "a_=de!?f");
        assert_eq!(edited("abcdef", 1..5, edits), "_=de!?");
    }

    #[test]
    #[should_panic(expected = "edits overlap")]
    fn overlapping_edits_are_a_fault() {
        in_order(vec![Edit::replace(1..3, ""), Edit::replace(2..4, "")]);
    }
}
