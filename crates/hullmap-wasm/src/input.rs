//! Arrays and strings from JavaScript, and the errors about them.

use js_sys::{Reflect, Uint8Array};
use wasm_bindgen::prelude::*;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** `Uint8Array<ArrayBuffer>`, in a form that TypeScript before 5.7 also accepts. */
export type Bytes = ReturnType<typeof Uint8Array.of>;
"#;

/// The bytes of a `Uint8Array` or an `ArrayBuffer`, also of another realm.
///
/// # Errors
/// Anything else.
pub fn bytes_of(value: &JsValue) -> Result<Vec<u8>, JsError> {
    let number = |name: &str| Reflect::get(value, &name.into()).ok().and_then(|own| own.as_f64());
    match (number("BYTES_PER_ELEMENT"), number("byteLength")) {
        (Some(1.0), _) | (None, Some(_)) => Ok(Uint8Array::new(value).to_vec()),
        _ => Err(error("expected the bytes of a file: a Uint8Array or an ArrayBuffer")),
    }
}

/// A string.
///
/// # Errors
/// Anything else.
pub fn text_of(value: &JsValue, expected: &str) -> Result<String, JsError> {
    value.as_string().ok_or_else(|| error(format!("expected {expected}")))
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

/// An error with a message.
pub fn error(text: impl std::fmt::Display) -> JsError {
    JsError::new(&text.to_string())
}
