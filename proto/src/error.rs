//! Which field of a message is at fault, and why.

use std::fmt;

/// A field of a message that holds what it must not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FieldError {
    /// Path of the field from the message that was converted: `cameras[2].pinhole.fx`.
    pub field: String,
    /// What is wrong with it, with the value.
    pub problem: String,
}

impl FieldError {
    /// The fault of a field of the message at hand.
    pub fn new(field: impl Into<String>, problem: impl Into<String>) -> Self {
        Self { field: field.into(), problem: problem.into() }
    }

    /// The same fault seen from the message that holds this one in its field `outer`.
    #[must_use]
    pub fn within(mut self, outer: impl fmt::Display) -> Self {
        self.field = if self.field.is_empty() {
            outer.to_string()
        } else {
            format!("{outer}.{}", self.field)
        };
        self
    }
}

impl fmt::Display for FieldError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.field, self.problem)
    }
}

impl std::error::Error for FieldError {}

/// The message of a field that must be present.
pub(crate) fn required<T>(field: &str, value: Option<T>) -> Result<T, FieldError> {
    value.ok_or_else(|| FieldError::new(field, "is absent"))
}

/// A number that must be finite.
pub(crate) fn finite(field: &str, value: f64) -> Result<f64, FieldError> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err(FieldError::new(field, format!("is {value:?}, must be finite")))
    }
}

/// A finite number that must not be negative.
pub(crate) fn not_negative(field: &str, value: f64) -> Result<f64, FieldError> {
    if finite(field, value)? >= 0.0 {
        Ok(value)
    } else {
        Err(FieldError::new(field, format!("is {value:?}, must be at least 0")))
    }
}

/// A finite number that must exceed 0.
pub(crate) fn positive(field: &str, value: f64) -> Result<f64, FieldError> {
    if finite(field, value)? > 0.0 {
        Ok(value)
    } else {
        Err(FieldError::new(field, format!("is {value:?}, must be more than 0")))
    }
}

/// Exactly `N` finite numbers.
pub(crate) fn finite_array<const N: usize>(
    field: &str,
    values: &[f64],
) -> Result<[f64; N], FieldError> {
    let array: [f64; N] = values.try_into().map_err(|_| {
        FieldError::new(field, format!("holds {} numbers, must hold {N}", values.len()))
    })?;
    for (index, value) in array.iter().enumerate() {
        finite(&format!("{field}[{index}]"), *value)?;
    }
    Ok(array)
}

/// A name that may be a segment of a path.
pub(crate) fn name(field: &str, value: String) -> Result<String, FieldError> {
    match flaneur_scene::ImageId::check_part(&value) {
        Ok(()) => Ok(value),
        Err(error) => Err(FieldError::new(field, error.to_string())),
    }
}
