//! One feature of a FlatGeobuf: its geometry and its properties, without trust.

use bytes::Bytes;
use flatgeobuf::{ColumnType, Feature, Geometry, Header, size_prefixed_root_as_feature};
use geozero::ColumnValue;

/// A verified feature.
#[derive(Clone, Debug)]
pub struct FgbFeature {
    bytes: Bytes,
}

impl FgbFeature {
    /// The feature in `bytes`, which begin with its size.
    pub(super) fn parse(bytes: Bytes) -> Result<Self, String> {
        size_prefixed_root_as_feature(&bytes)
            .map_err(|e| format!("the feature is no flatbuffer: {e}"))?;
        Ok(Self { bytes })
    }

    /// The geometry, where the feature has one. Its vectors are within the feature, but their
    /// lengths need not agree with each other.
    pub fn geometry(&self) -> Option<Geometry<'_>> {
        self.feature().geometry()
    }

    /// Column number and value of each property that is set, in the feature's order.
    /// `header` is that of its file. Errors say what is wrong.
    pub fn properties<'a>(
        &'a self,
        header: &Header<'_>,
    ) -> Result<Vec<(usize, ColumnValue<'a>)>, String> {
        let mut rest = self.feature().properties().map_or(&[][..], |p| p.bytes());
        let columns = header.columns();
        let mut properties = Vec::new();
        while !rest.is_empty() {
            let index = usize::from(u16::from_le_bytes(take(&mut rest)?));
            let column = columns
                .filter(|columns| index < columns.len())
                .ok_or_else(|| format!("a property of column {index}, which does not exist"))?
                .get(index);
            let value = match column.type_() {
                ColumnType::Byte => ColumnValue::Byte(i8::from_le_bytes(take(&mut rest)?)),
                ColumnType::UByte => ColumnValue::UByte(u8::from_le_bytes(take(&mut rest)?)),
                ColumnType::Bool => ColumnValue::Bool(take::<1>(&mut rest)? != [0]),
                ColumnType::Short => ColumnValue::Short(i16::from_le_bytes(take(&mut rest)?)),
                ColumnType::UShort => ColumnValue::UShort(u16::from_le_bytes(take(&mut rest)?)),
                ColumnType::Int => ColumnValue::Int(i32::from_le_bytes(take(&mut rest)?)),
                ColumnType::UInt => ColumnValue::UInt(u32::from_le_bytes(take(&mut rest)?)),
                ColumnType::Long => ColumnValue::Long(i64::from_le_bytes(take(&mut rest)?)),
                ColumnType::ULong => ColumnValue::ULong(u64::from_le_bytes(take(&mut rest)?)),
                ColumnType::Float => ColumnValue::Float(f32::from_le_bytes(take(&mut rest)?)),
                ColumnType::Double => ColumnValue::Double(f64::from_le_bytes(take(&mut rest)?)),
                ColumnType::String => ColumnValue::String(take_text(&mut rest)?),
                ColumnType::Json => ColumnValue::Json(take_text(&mut rest)?),
                ColumnType::DateTime => ColumnValue::DateTime(take_text(&mut rest)?),
                ColumnType::Binary => ColumnValue::Binary(take_sized(&mut rest)?),
                other => return Err(format!("column {index} is of unknown type {}", other.0)),
            };
            properties.push((index, value));
        }
        Ok(properties)
    }

    fn feature(&self) -> Feature<'_> {
        size_prefixed_root_as_feature(&self.bytes).expect("verified when it was parsed")
    }
}

fn take<const N: usize>(rest: &mut &[u8]) -> Result<[u8; N], String> {
    let (taken, left) = rest.split_first_chunk().ok_or("a property is cut short")?;
    *rest = left;
    Ok(*taken)
}

fn take_sized<'a>(rest: &mut &'a [u8]) -> Result<&'a [u8], String> {
    let length = u32::from_le_bytes(take(rest)?) as usize;
    let (taken, left) = rest
        .split_at_checked(length)
        .ok_or_else(|| format!("a property of {length} bytes where {} are left", rest.len()))?;
    *rest = left;
    Ok(taken)
}

fn take_text<'a>(rest: &mut &'a [u8]) -> Result<&'a str, String> {
    std::str::from_utf8(take_sized(rest)?).map_err(|e| format!("a property is no UTF-8: {e}"))
}
