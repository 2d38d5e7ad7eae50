//! Edits of a text: spans that are replaced. Everything outside of them keeps its bytes.

use std::ops::Range;

/// Replacement of a span of a text; an empty span is an insertion.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edit {
    /// Bytes of the decoded text.
    pub span: Range<usize>,
    pub text: String,
}

impl Edit {
    pub fn replace(span: Range<usize>, text: impl Into<String>) -> Self {
        Self { span, text: text.into() }
    }

    pub fn insert(at: usize, text: impl Into<String>) -> Self {
        Self { span: at..at, text: text.into() }
    }
}

/// The edits by their places. Insertions at one place keep their order. An edit inside a span that
/// another edit replaces is dropped, for instance in a removed element.
pub fn in_order(mut edits: Vec<Edit>) -> Vec<Edit> {
    // An insertion before a replacement at the same place; of two replacements, the longer first.
    edits.sort_by_key(|edit| (edit.span.start, !edit.span.is_empty(), usize::MAX - edit.span.end));
    let mut end = 0;
    edits.retain(|edit| {
        let is_kept = edit.span.start >= end;
        end = end.max(edit.span.end);
        is_kept
    });
    edits
}

/// The edited text of the span `within`, which contains all edits.
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
    fn edits_in_replaced_spans_are_dropped() {
        let edits = vec![Edit::replace(2..3, "x"), Edit::replace(1..4, ""), Edit::insert(1, "!"), Edit::insert(4, "?")];
        assert_eq!(edited("abcdef", 0..6, edits), "a!?ef");
    }
}
