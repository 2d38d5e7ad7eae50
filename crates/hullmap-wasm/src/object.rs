//! Plain JavaScript objects: nothing to free, and readable in a console.

use hullmap::glam::DVec3;
use js_sys::{Float64Array, Object, Reflect};
use wasm_bindgen::prelude::*;

/// An object under construction.
pub struct Plain(Object);

impl Plain {
    /// An object without properties.
    pub fn new() -> Self {
        Self(Object::new())
    }

    /// Adds a property.
    pub fn with(self, key: &str, value: impl Into<JsValue>) -> Self {
        // Setting a property of a plain object cannot fail.
        let _ = Reflect::set(&self.0, &key.into(), &value.into());
        self
    }

    /// Adds a vector as a `Float64Array` of three.
    pub fn with_vector(self, key: &str, vector: DVec3) -> Self {
        self.with(key, vector_of(vector))
    }

    /// The object, as the interface that TypeScript knows.
    pub fn done<T: JsCast>(self) -> T {
        self.0.unchecked_into()
    }
}

/// A vector as a `Float64Array` of three.
pub fn vector_of(vector: DVec3) -> Float64Array {
    Float64Array::from(vector.to_array().as_slice())
}

/// An error with a message.
pub fn error(text: impl std::fmt::Display) -> JsError {
    JsError::new(&text.to_string())
}
