//! The attributes of a feature as JSON.

use flatgeobuf::Header;
use geozero::ColumnValue;
use serde_json::{Map, Number, Value};

use super::FgbFeature;

/// Every attribute of `feature` that has a value, by the names of the columns of `header`.
///
/// Numbers that JSON does not know (NaN, infinities) are left out; binary values are given in
/// hexadecimal.
///
/// # Errors
///
/// Says which attribute is cut short, has no column, or is not JSON where it should be.
pub fn attributes(feature: &FgbFeature, header: &Header<'_>) -> Result<Map<String, Value>, String> {
    let mut map = Map::new();
    let Some(columns) = header.columns() else { return Ok(map) };
    for (index, value) in feature.properties(header)? {
        // The index was checked against the columns when the value was read.
        let name = columns.get(index).name();
        let value = match value {
            ColumnValue::Byte(n) => n.into(),
            ColumnValue::UByte(n) => n.into(),
            ColumnValue::Bool(flag) => flag.into(),
            ColumnValue::Short(n) => n.into(),
            ColumnValue::UShort(n) => n.into(),
            ColumnValue::Int(n) => n.into(),
            ColumnValue::UInt(n) => n.into(),
            ColumnValue::Long(n) => n.into(),
            ColumnValue::ULong(n) => n.into(),
            // Through the shortest decimal form, so that 0.1f32 stays 0.1.
            ColumnValue::Float(n) => {
                let number = n.to_string().parse().ok().and_then(Number::from_f64);
                number.map_or(Value::Null, Value::Number)
            }
            ColumnValue::Double(n) => n.into(),
            ColumnValue::String(text) | ColumnValue::DateTime(text) => text.into(),
            ColumnValue::Json(text) => serde_json::from_str(text)
                .map_err(|error| format!("attribute {name:?} is not JSON: {error}"))?,
            ColumnValue::Binary(bytes) => {
                bytes.iter().map(|byte| format!("{byte:02x}")).collect::<String>().into()
            }
        };
        if !value.is_null() {
            map.insert(name.to_owned(), value);
        }
    }
    Ok(map)
}
