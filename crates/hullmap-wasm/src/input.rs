//! Arrays from JavaScript, and the errors about them.

use js_sys::{Reflect, Uint8Array};
use wasm_bindgen::{JsError, JsValue};

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

/// The error about a file that cannot be opened, with the classes of JavaScript.
pub fn wrong_kind(fault: impl std::fmt::Display) -> JsError {
    let rust = "open it as one, or any kind with `Asset::open`";
    error(fault.to_string().replace(rust, "new Pack opens packs, new Level triangle meshes and height fields"))
}

/// An error with a message.
pub fn error(text: impl std::fmt::Display) -> JsError {
    JsError::new(&text.to_string())
}
