//! Arrays from JavaScript, and the errors about them.

use wasm_bindgen::JsError;

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
