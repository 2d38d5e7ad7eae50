//! Insertions into JSON text. All else keeps its bytes: order, spaces, numbers, unknown members.

use std::collections::BTreeMap;
use std::ops::Range;

use serde_json::value::RawValue;

/// The last one of equal names counts, as in other readers.
pub type Members<'a> = BTreeMap<String, &'a RawValue>;

pub fn members(object: &str) -> Result<Members<'_>, String> {
    serde_json::from_str(object).map_err(|error| format!("expected an object: {error}"))
}

pub fn elements(list: &str) -> Result<Vec<&RawValue>, String> {
    serde_json::from_str(list).map_err(|error| format!("expected a list: {error}"))
}

pub struct Edits<'a> {
    text: &'a str,
    edits: Vec<(Range<usize>, String)>,
}

impl<'a> Edits<'a> {
    pub fn new(text: &'a str) -> Self {
        Self { text, edits: Vec::new() }
    }

    fn place(&self, part: &str) -> Range<usize> {
        let start = part.as_ptr() as usize - self.text.as_ptr() as usize;
        start..start + part.len()
    }

    pub fn replace(&mut self, part: &'a str, by: String) {
        self.edits.push((self.place(part), by));
    }

    /// Appends elements to a list, once for each list. `list` is its text.
    pub fn append(&mut self, list: &'a str, new: &[String]) -> Result<(), String> {
        let is_empty = elements(list)?.is_empty();
        self.insert_before_end(list, is_empty, new);
        Ok(())
    }

    /// Adds members to an object, once for each object. `object` is its text, without these names.
    pub fn add(&mut self, object: &'a str, new: &[(&str, String)]) -> Result<(), String> {
        let is_empty = members(object)?.is_empty();
        let new: Vec<String> = new.iter().map(|(name, value)| format!("\"{name}\":{value}")).collect();
        self.insert_before_end(object, is_empty, &new);
        Ok(())
    }

    fn insert_before_end(&mut self, part: &'a str, is_empty: bool, new: &[String]) {
        if new.is_empty() {
            return;
        }
        let end = self.place(part.trim_end()).end - 1;
        // After the last element, and before white space in front of the bracket.
        let at = self.text.get(..end).map_or(end, |before| before.trim_end().len());
        let comma = if is_empty { "" } else { "," };
        self.edits.push((at..at, format!("{comma}{}", new.join(","))));
    }

    pub fn apply(mut self) -> String {
        self.edits.sort_by_key(|(range, _)| range.start);
        let mut text = String::with_capacity(self.text.len());
        let mut done = 0;
        for (range, new) in &self.edits {
            text.push_str(self.text.get(done..range.start).unwrap_or_default());
            text.push_str(new);
            done = range.end;
        }
        text.push_str(self.text.get(done..).unwrap_or_default());
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_else_keeps_its_bytes() {
        let text = "{ \"a\" : [1.0, 2e3 ],\n\t\"b\":{},\"c\":[ ], \"a\\\"]\": {\"x\":1}\n}\n";
        let root = members(text).unwrap();
        let mut edits = Edits::new(text);
        edits.append(root["a"].get(), &["3".to_owned(), "4".to_owned()]).unwrap();
        edits.append(root["c"].get(), &["5".to_owned()]).unwrap();
        edits.add(root["b"].get(), &[("y", "6".to_owned())]).unwrap();
        edits.add(root["a\"]"].get(), &[("y", "7".to_owned()), ("z", "8".to_owned())]).unwrap();
        edits.add(text, &[("d", "9".to_owned())]).unwrap();
        assert_eq!(
            edits.apply(),
            "{ \"a\" : [1.0, 2e3,3,4 ],\n\t\"b\":{\"y\":6},\"c\":[5 ], \"a\\\"]\": {\"x\":1,\"y\":7,\"z\":8},\"d\":9\n}\n"
        );
        let mut edits = Edits::new("[12]");
        edits.replace(elements("[12]").map(|_| "[12]").unwrap(), "0".to_owned());
        assert_eq!(Edits::new(text).apply(), text);
        assert!(elements("{}").is_err() && members("[1]").is_err());
    }
}
