//! Which photographs are held out, and which are left to render them from.

use std::collections::{BTreeMap, BTreeSet};
use std::num::NonZero;

use flaneur_scene::ImageId;

/// What is held out of the photographs that take part.
pub(crate) enum Choice<'a> {
    /// In the order of their names, panoramas 0, N, 2N, … stay, and all others are held out.
    /// What a rig took at once is one panorama: its photographs stay or go together.
    Every(NonZero<usize>),
    /// The photographs that this names are held out.
    Where(&'a dyn Fn(&ImageId) -> bool),
}

/// The outcome.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Split {
    /// What may be used.
    pub(crate) sources: BTreeSet<ImageId>,
    /// What was held out, in the order of the names.
    pub(crate) targets: BTreeSet<ImageId>,
}

/// Why there is nothing to evaluate.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum HoldOutError {
    /// Everything stays.
    #[error(
        "all {panoramas} panoramas that take part stay sources; hold some out: a larger --sources \
         every:N, or fewer photographs behind --only"
    )]
    NothingHeldOut {
        /// How many take part.
        panoramas: usize,
    },
    /// Nothing stays.
    #[error(
        "all {photographs} photographs that take part are held out, and none is left to render \
         them from; hold fewer out"
    )]
    NoSource {
        /// How many take part.
        photographs: usize,
    },
}

impl Split {
    /// Splits `photographs`, which take part and may come in any order.
    pub(crate) fn new(
        photographs: impl Iterator<Item = ImageId>,
        choice: &Choice<'_>,
    ) -> Result<Self, HoldOutError> {
        let mut panoramas: BTreeMap<String, Vec<ImageId>> = BTreeMap::new();
        for id in photographs {
            panoramas.entry(id.panorama().to_owned()).or_default().push(id);
        }
        let mut split = Self::default();
        for (index, id) in
            panoramas.values().enumerate().flat_map(|(i, p)| p.iter().map(move |id| (i, id)))
        {
            let is_source = match choice {
                Choice::Every(n) => index.is_multiple_of(n.get()),
                Choice::Where(held_out) => !held_out(id),
            };
            if is_source { &mut split.sources } else { &mut split.targets }.insert(id.clone());
        }
        if split.targets.is_empty() {
            return Err(HoldOutError::NothingHeldOut { panoramas: panoramas.len() });
        }
        if split.sources.is_empty() {
            return Err(HoldOutError::NoSource { photographs: split.targets.len() });
        }
        Ok(split)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ids(names: &[&str]) -> Vec<ImageId> {
        names.iter().map(|name| name.parse().expect("an id")).collect()
    }

    fn every(n: usize, names: &[&str]) -> Result<[Vec<String>; 2], HoldOutError> {
        let choice = Choice::Every(NonZero::new(n).expect("not zero"));
        let split = Split::new(ids(names).into_iter(), &choice)?;
        Ok([split.sources, split.targets].map(|set| set.iter().map(ImageId::to_string).collect()))
    }

    #[test]
    fn every_nth_panorama_stays_in_name_order() {
        let [sources, targets] =
            every(2, &["02_4/2", "02_1/2", "02_0/2", "02_3/2", "02_2/2"]).expect("a split");
        assert_eq!(sources, ["02_0/2", "02_2/2", "02_4/2"]);
        assert_eq!(targets, ["02_1/2", "02_3/2"]);
        let [sources, targets] =
            every(8, &["a/1", "b/1", "c/1", "d/1", "e/1", "f/1", "g/1", "h/1", "i/1"])
                .expect("a split");
        assert_eq!((sources.join(" "), targets.len()), ("a/1 i/1".to_owned(), 7));
    }

    #[test]
    fn a_rig_stays_or_goes_as_a_whole() {
        let [sources, targets] =
            every(2, &["491/300", "490/301", "490/300", "491/301", "492/300"]).expect("a split");
        assert_eq!(sources, ["490/300", "490/301", "492/300"]);
        assert_eq!(targets, ["491/300", "491/301"]);
    }

    #[test]
    fn named_photographs_are_held_out() {
        let held_out = |id: &ImageId| id.panorama() == "b";
        let all = ids(&["a/1", "b/1", "b/2"]);
        let split = Split::new(all.into_iter(), &Choice::Where(&held_out)).expect("a split");
        assert_eq!((split.sources.len(), split.targets.len()), (1, 2));
    }

    #[test]
    fn a_split_has_two_sides() {
        assert_eq!(every(2, &["a/1"]), Err(HoldOutError::NothingHeldOut { panoramas: 1 }));
        assert_eq!(every(1, &["a/1", "b/1"]), Err(HoldOutError::NothingHeldOut { panoramas: 2 }));
        let everything = Split::new(ids(&["a/1", "b/1"]).into_iter(), &Choice::Where(&|_| true));
        assert_eq!(everything, Err(HoldOutError::NoSource { photographs: 2 }));
    }
}
