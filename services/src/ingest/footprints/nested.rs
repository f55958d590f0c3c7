//! Numbers in nested JSON arrays, as GeoJSON's coordinates and CityJSON's boundaries are, without
//! a box for every array.

use std::fmt;
use std::ops::Range;

use serde::de::{Deserialize, DeserializeSeed, Deserializer, Error, SeqAccess, Visitor};

/// The deepest nesting: solids, shells, faces, rings, vertices.
const DEEPEST: u8 = 5;

/// Numbers in reading order, and where the arrays end that hold them.
#[derive(Default)]
pub(super) struct Nested {
    numbers: Vec<f64>,
    /// Ends of the innermost arrays among the numbers, of the arrays of those among them, and of
    /// the arrays of the latter.
    ends: [Vec<usize>; 3],
    /// How deep numbers are nested; 0 where there is none.
    pub(super) depth: u8,
    /// Whether not all numbers are as deep: then the arrays mean nothing.
    pub(super) uneven: bool,
}

impl Nested {
    /// The arrays of a level (0 the innermost), each as a range of arrays of the level below, or of
    /// numbers.
    pub(super) fn lists(&self, level: usize) -> impl Iterator<Item = Range<usize>> {
        self.lists_in(level, 0..self.ends[level].len())
    }

    /// Those of the arrays of a level that a range from the level above selects.
    pub(super) fn lists_in(
        &self,
        level: usize,
        range: Range<usize>,
    ) -> impl Iterator<Item = Range<usize>> {
        let ends = &self.ends[level];
        range.map(move |i| i.checked_sub(1).map_or(0, |before| ends[before])..ends[i])
    }

    /// The numbers of an innermost array.
    pub(super) fn numbers(&self, range: Range<usize>) -> &[f64] {
        &self.numbers[range]
    }
}

impl<'de> Deserialize<'de> for Nested {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        let mut found = Self::default();
        if let Item::Array(depth) = (Level { found: &mut found, above: 0 }).deserialize(source)? {
            found.depth = depth;
        }
        Ok(found)
    }
}

/// What was read.
#[derive(Clone, Copy, PartialEq)]
enum Item {
    Number,
    /// An array whose numbers are this deep.
    Array(u8),
    /// An array without numbers.
    Empty,
}

struct Level<'a> {
    found: &'a mut Nested,
    /// Arrays around this one.
    above: u8,
}

impl<'de> DeserializeSeed<'de> for Level<'_> {
    type Value = Item;

    fn deserialize<D: Deserializer<'de>>(self, source: D) -> Result<Item, D::Error> {
        source.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Level<'_> {
    type Value = Item;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("nested arrays of numbers")
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<Item, E> {
        self.found.numbers.push(number);
        Ok(Item::Number)
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<Item, E> {
        self.visit_f64(number as f64)
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<Item, E> {
        self.visit_f64(number as f64)
    }

    /// `null` is how some programs write NaN.
    fn visit_unit<E: Error>(self) -> Result<Item, E> {
        self.visit_f64(f64::NAN)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Item, A::Error> {
        let Self { found, above } = self;
        if above >= DEEPEST {
            return Err(A::Error::custom(format!("arrays are nested more than {DEEPEST} deep")));
        }
        let mut holds = Item::Empty;
        while let Some(item) = list.next_element_seed(Level { found, above: above + 1 })? {
            if item == Item::Empty {
                continue;
            }
            found.uneven |= holds != Item::Empty && holds != item;
            holds = item;
        }
        let depth = match holds {
            Item::Empty => return Ok(Item::Empty),
            Item::Number => 0,
            Item::Array(depth) => depth,
        };
        let below = match depth {
            0 => found.numbers.len(),
            n => found.ends.get(usize::from(n) - 1).map_or(0, Vec::len),
        };
        if let Some(ends) = found.ends.get_mut(usize::from(depth)) {
            ends.push(below);
        }
        Ok(Item::Array(depth + 1))
    }
}
