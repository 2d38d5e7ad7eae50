//! Plain JavaScript objects, which need not be freed and are readable in a console: one answer with
//! its fields, or many answers as one array for each field.

use std::cell::RefCell;

use hullmap::glam::DVec3;
use hullmap::{Fields, Value};
use js_sys::{Array, Float64Array, Object, Reflect, Uint8Array, Uint32Array};
use wasm_bindgen::prelude::*;

use crate::input::error;

/// Types of answers, with the comments of the structs in Rust.
#[wasm_bindgen(typescript_custom_section)]
const ANSWERS: &str = include_str!("answers.d.ts");

/// An object under construction.
pub struct Plain(Object);

impl Plain {
    /// An object without properties.
    pub fn new() -> Self {
        Self(Object::new())
    }

    /// One answer, with its fields in the names of JavaScript.
    pub fn from_answer(answer: &impl Fields) -> Self {
        answer.fields().fold(Self::new(), |plain, (name, value)| {
            let value = match value {
                Value::Flag(is) => is.into(),
                Value::Word(word, _) => word_of(word),
                Value::Count(count) => count.into(),
                Value::Number(number) => number.into(),
                Value::Vector(vector) => vector_of(vector).into(),
                Value::Parts(parts) => parts_of(parts).into(),
            };
            plain.with_key(&key_of(name), &value)
        })
    }

    /// Adds a property.
    pub fn with(self, key: &'static str, value: impl Into<JsValue>) -> Self {
        self.with_key(&word_of(key), &value.into())
    }

    fn with_key(self, key: &JsValue, value: &JsValue) -> Self {
        // Setting a property of a plain object cannot fail.
        let _ = Reflect::set(&self.0, key, value);
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
    /// An empty column for values like this one.
    fn like(value: Value) -> Self {
        match value {
            Value::Flag(_) => Self::Flags(Vec::new()),
            Value::Word(..) => Self::Words(Array::new()),
            Value::Count(_) | Value::Parts(_) => Self::Counts(Vec::new()),
            Value::Number(_) | Value::Vector(_) => Self::Numbers(Vec::new()),
        }
    }

    fn push(&mut self, value: Value) {
        match (self, value) {
            (Self::Flags(column), Value::Flag(is)) => column.push(is.into()),
            (Self::Words(column), Value::Word(word, _)) => {
                column.push(&word_of(word));
            }
            (Self::Counts(column), Value::Count(count)) => column.push(count),
            (Self::Counts(column), Value::Parts(parts)) => column.extend(parts),
            (Self::Numbers(column), Value::Number(number)) => column.push(number),
            (Self::Numbers(column), Value::Vector(vector)) => column.extend(vector.to_array()),
            // The answers of one query have the same fields.
            _ => {}
        }
    }
}

/// Many answers of one query.
pub struct Columns(Vec<(&'static str, Column)>);

impl Columns {
    /// Empty columns for the fields of an answer.
    pub fn of<A: Fields>() -> Self {
        Self(A::default().fields().map(|(name, value)| (name, Column::like(value))).collect())
    }

    /// Adds an answer.
    pub fn push(&mut self, answer: &impl Fields) {
        for ((_, column), (_, value)) in self.0.iter_mut().zip(answer.fields()) {
            column.push(value);
        }
    }

    /// The arrays, as the interface that TypeScript knows.
    pub fn done<T: JsCast>(self) -> T {
        let plain = self.0.into_iter().fold(Plain::new(), |plain, (name, column)| {
            let array = match column {
                Column::Flags(column) => Uint8Array::from(column.as_slice()).into(),
                Column::Words(column) => column.into(),
                Column::Counts(column) => Uint32Array::from(column.as_slice()).into(),
                Column::Numbers(column) => Float64Array::from(column.as_slice()).into(),
            };
            plain.with_key(&key_of(name), &array)
        });
        plain.done()
    }
}

/// Strings of JavaScript, by the words that they were made from.
type Known = RefCell<Vec<(&'static str, JsValue)>>;

thread_local! {
    /// Words of answers, and names of properties: about forty.
    static WORDS: Known = const { RefCell::new(Vec::new()) };
    /// Names of fields, in the style of JavaScript.
    static KEYS: Known = const { RefCell::new(Vec::new()) };
}

/// A string of JavaScript, which is made once: that takes longer than a short query.
fn once(known: &Known, word: &'static str, make: impl FnOnce() -> JsValue) -> JsValue {
    let mut known = known.borrow_mut();
    if let Some((_, known)) = known.iter().find(|(text, _)| *text == word) {
        return known.clone();
    }
    let made = make();
    known.push((word, made.clone()));
    made
}

/// A word as a string of JavaScript.
pub fn word_of(word: &'static str) -> JsValue {
    WORDS.with(|known| once(known, word, || JsValue::from_str(word)))
}

/// The name of a field in JavaScript: `depth_lower` is `depthLower`.
fn key_of(name: &'static str) -> JsValue {
    let make = || {
        let mut words = name.split('_');
        let mut key = words.next().unwrap_or_default().to_owned();
        for word in words {
            let (first, rest) = word.split_at_checked(1).unwrap_or_default();
            key.extend([&first.to_ascii_uppercase(), rest]);
        }
        JsValue::from_str(&key)
    };
    KEYS.with(|known| once(known, name, make))
}

/// Indices of hulls as a `Uint32Array` of two.
pub fn parts_of(parts: [u32; 2]) -> Uint32Array {
    Uint32Array::from(parts.as_slice())
}

/// A vector as a `Float64Array` of three.
pub fn vector_of(vector: DVec3) -> Float64Array {
    Float64Array::from(vector.to_array().as_slice())
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
