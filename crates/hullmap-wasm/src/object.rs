//! Plain JavaScript objects, which need not be freed and are readable in a console: one answer with
//! its fields, or many answers as one array for each field.

use std::cell::RefCell;

use hullmap::glam::DVec3;
use js_sys::{Array, Float64Array, Object, Reflect, Uint8Array, Uint32Array};
use wasm_bindgen::prelude::*;

/// A field of an answer.
#[derive(Clone, Copy, Debug)]
pub enum Field {
    /// True or false; in an array, 1 or 0.
    Flag(bool),
    /// One of a few words.
    Word(&'static str),
    /// A count or an index.
    Count(u32),
    /// A number.
    Number(f64),
    /// A vector of three numbers.
    Vector(DVec3),
    /// Indices of hulls in A and in B.
    Parts([u32; 2]),
}

/// The fields of one answer, by their names in JavaScript.
pub type Fields = Vec<(&'static str, Field)>;

/// An object under construction.
pub struct Plain(Object);

impl Plain {
    /// An object without properties.
    pub fn new() -> Self {
        Self(Object::new())
    }

    /// One answer.
    pub fn from_fields(fields: &[(&'static str, Field)]) -> Self {
        fields.iter().fold(Self::new(), |plain, &(key, field)| match field {
            Field::Flag(is) => plain.with(key, is),
            Field::Word(word) => plain.with(key, word_of(word)),
            Field::Count(count) => plain.with(key, count),
            Field::Number(number) => plain.with(key, number),
            Field::Vector(vector) => plain.with(key, vector_of(vector)),
            Field::Parts(parts) => plain.with(key, parts_of(parts)),
        })
    }

    /// Adds a property.
    pub fn with(self, key: &'static str, value: impl Into<JsValue>) -> Self {
        // Setting a property of a plain object cannot fail.
        let _ = Reflect::set(&self.0, &word_of(key), &value.into());
        self
    }

    /// The object, as the interface that TypeScript knows.
    pub fn done<T: JsCast>(self) -> T {
        self.0.unchecked_into()
    }
}

/// One field of many answers.
enum Column {
    Flags(Vec<u8>),
    Words(Array),
    Counts(Vec<u32>),
    Numbers(Vec<f64>),
}

impl Column {
    fn push(&mut self, field: Field) {
        match (self, field) {
            (Self::Flags(column), Field::Flag(is)) => column.push(is.into()),
            (Self::Words(column), Field::Word(word)) => {
                column.push(&word_of(word));
            }
            (Self::Counts(column), Field::Count(count)) => column.push(count),
            (Self::Counts(column), Field::Parts(parts)) => column.extend(parts),
            (Self::Numbers(column), Field::Number(number)) => column.push(number),
            (Self::Numbers(column), Field::Vector(vector)) => column.extend(vector.to_array()),
            // The answers of one query have the same fields.
            _ => {}
        }
    }
}

/// Many answers of one query.
pub struct Columns(Vec<(&'static str, Column)>);

impl Columns {
    /// Empty columns for answers with these fields.
    pub fn like(fields: &[(&'static str, Field)]) -> Self {
        let column = |&(key, field): &(&'static str, Field)| match field {
            Field::Flag(_) => (key, Column::Flags(Vec::new())),
            Field::Word(_) => (key, Column::Words(Array::new())),
            Field::Count(_) | Field::Parts(_) => (key, Column::Counts(Vec::new())),
            Field::Number(_) | Field::Vector(_) => (key, Column::Numbers(Vec::new())),
        };
        Self(fields.iter().map(column).collect())
    }

    /// Adds an answer.
    pub fn push(&mut self, fields: &[(&'static str, Field)]) {
        for ((_, column), &(_, field)) in self.0.iter_mut().zip(fields) {
            column.push(field);
        }
    }

    /// The arrays, as the interface that TypeScript knows.
    pub fn done<T: JsCast>(self) -> T {
        let plain = self.0.into_iter().fold(Plain::new(), |plain, (key, column)| match column {
            Column::Flags(column) => plain.with(key, Uint8Array::from(column.as_slice())),
            Column::Words(column) => plain.with(key, column),
            Column::Counts(column) => plain.with(key, Uint32Array::from(column.as_slice())),
            Column::Numbers(column) => plain.with(key, Float64Array::from(column.as_slice())),
        });
        plain.done()
    }
}

thread_local! {
    /// Names of fields and words of answers as strings of JavaScript: about forty.
    static WORDS: RefCell<Vec<(&'static str, JsValue)>> = const { RefCell::new(Vec::new()) };
}

/// A word as a string of JavaScript, which is made once: that takes longer than a short query.
pub fn word_of(word: &'static str) -> JsValue {
    WORDS.with_borrow_mut(|words| {
        if let Some((_, known)) = words.iter().find(|(text, _)| *text == word) {
            return known.clone();
        }
        let made = JsValue::from_str(word);
        words.push((word, made.clone()));
        made
    })
}

/// Indices of hulls as a `Uint32Array` of two.
pub fn parts_of(parts: [u32; 2]) -> Uint32Array {
    Uint32Array::from(parts.as_slice())
}

/// A vector as a `Float64Array` of three.
pub fn vector_of(vector: DVec3) -> Float64Array {
    Float64Array::from(vector.to_array().as_slice())
}

/// The rows of an array that has three numbers each.
///
/// # Errors
/// The length is not a multiple of three.
pub fn rows_of<'n, T>(name: &str, numbers: &'n [T]) -> Result<&'n [[T; 3]], JsError> {
    match numbers.as_chunks::<3>() {
        (rows, []) => Ok(rows),
        _ => Err(error(format!("{name} must have three numbers each, found {} in all", numbers.len()))),
    }
}

/// A vector from an array of three numbers.
///
/// # Errors
/// The array has another length.
pub fn vector_from(name: &str, numbers: &[f64]) -> Result<DVec3, JsError> {
    let found = numbers.len();
    let &[x, y, z] = numbers else { return Err(error(format!("{name}: expected three numbers, found {found}"))) };
    Ok(DVec3::new(x, y, z))
}

/// An error with a message.
pub fn error(text: impl std::fmt::Display) -> JsError {
    JsError::new(&text.to_string())
}
