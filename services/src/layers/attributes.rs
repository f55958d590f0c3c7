//! Typed columns for attributes that come as JSON.

use std::collections::HashMap;

use flatgeobuf::ColumnType;
use geozero::ColumnValue;
use serde_json::{Map, Value};

/// The most attributes that get a column of their own; the values of the others are kept
/// together, as one JSON object. Map data with free tags can have thousands.
const MAX_COLUMNS: usize = 512;

/// Names that begin so are Flaneur's own columns.
const RESERVED: &str = "flaneur_";

/// The columns that hold a layer's attributes, found by looking at all of them once.
#[derive(Default)]
pub struct AttributeColumns {
    columns: Vec<(String, Kind)>,
    by_name: HashMap<String, usize>,
    overflow: bool,
}

/// What values a column has held so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Bool,
    /// Integers within ±2⁵³, which doubles hold exactly.
    Small,
    Long,
    ULong,
    Double,
    Text,
    Json,
}

impl AttributeColumns {
    /// Makes room for the attributes of one feature. Names beginning with `flaneur_` are skipped:
    /// they are left over from a layer that Flaneur wrote, and are written anew.
    pub fn observe(&mut self, attributes: &Map<String, Value>) {
        for (name, value) in attributes {
            let Some(kind) = Kind::of(value).filter(|_| !name.starts_with(RESERVED)) else {
                continue;
            };
            match self.by_name.get(name) {
                Some(&index) => self.columns[index].1 = self.columns[index].1.join(kind),
                None if self.columns.len() < MAX_COLUMNS => {
                    self.by_name.insert(name.clone(), self.columns.len());
                    self.columns.push((name.clone(), kind));
                }
                None => self.overflow = true,
            }
        }
    }

    /// Name and type of each column, in order.
    pub fn columns(&self) -> impl Iterator<Item = (&str, ColumnType)> {
        self.columns.iter().map(|(name, kind)| (name.as_str(), kind.column_type()))
    }

    /// Number of columns.
    pub fn len(&self) -> usize {
        self.columns.len()
    }

    /// Whether there is no column.
    pub fn is_empty(&self) -> bool {
        self.columns.is_empty()
    }

    /// Whether some attributes have no column.
    pub fn overflows(&self) -> bool {
        self.overflow
    }

    /// Calls `write` with column, name and value of each attribute, and gives back those that
    /// have no column as a JSON object. Nulls have no value to write.
    pub fn write<E>(
        &self,
        attributes: &Map<String, Value>,
        mut write: impl FnMut(usize, &str, &ColumnValue<'_>) -> Result<(), E>,
    ) -> Result<Map<String, Value>, E> {
        let mut rest = Map::new();
        for (name, value) in attributes {
            if name.starts_with(RESERVED) || value.is_null() {
                continue;
            }
            let Some(&index) = self.by_name.get(name) else {
                rest.insert(name.clone(), value.clone());
                continue;
            };
            let text;
            let value = match (self.columns[index].1, value) {
                (Kind::Bool, Value::Bool(flag)) => ColumnValue::Bool(*flag),
                (Kind::Small | Kind::Long, Value::Number(n)) if let Some(n) = n.as_i64() => {
                    ColumnValue::Long(n)
                }
                (Kind::ULong, Value::Number(n)) if let Some(n) = n.as_u64() => {
                    ColumnValue::ULong(n)
                }
                (Kind::Double, Value::Number(n)) if let Some(n) = n.as_f64() => {
                    ColumnValue::Double(n)
                }
                (Kind::Text, Value::String(string)) => ColumnValue::String(string),
                (_, value) => {
                    text = value.to_string();
                    ColumnValue::Json(&text)
                }
            };
            write(index, name, &value)?;
        }
        Ok(rest)
    }
}

impl Kind {
    fn of(value: &Value) -> Option<Self> {
        Some(match value {
            Value::Null => return None,
            Value::Bool(_) => Self::Bool,
            Value::String(_) => Self::Text,
            Value::Array(_) | Value::Object(_) => Self::Json,
            Value::Number(n) => match n.as_i64() {
                Some(n) if n.unsigned_abs() <= 1 << 53 => Self::Small,
                Some(_) => Self::Long,
                None if n.is_u64() => Self::ULong,
                None => Self::Double,
            },
        })
    }

    /// The narrowest kind that holds the values of both without loss.
    fn join(self, other: Self) -> Self {
        match (self, other) {
            (a, b) if a == b => a,
            (Self::Small, Self::Long) | (Self::Long, Self::Small) => Self::Long,
            (Self::Small, Self::Double) | (Self::Double, Self::Small) => Self::Double,
            _ => Self::Json,
        }
    }

    fn column_type(self) -> ColumnType {
        match self {
            Self::Bool => ColumnType::Bool,
            Self::Small | Self::Long => ColumnType::Long,
            Self::ULong => ColumnType::ULong,
            Self::Double => ColumnType::Double,
            Self::Text => ColumnType::String,
            Self::Json => ColumnType::Json,
        }
    }
}
