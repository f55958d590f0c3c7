//! Against a model that is slow and obvious; and on the walk for which it is made.

use proptest::prelude::*;

use super::*;

/// The rules once more, on vectors: the entry used last is at the end.
#[derive(Debug, Default)]
struct Model {
    capacity: u64,
    working_set: u64,
    probation: Vec<(u8, u64)>,
    protected: Vec<(u8, u64)>,
}

fn weight(entries: &[(u8, u64)]) -> u64 {
    entries.iter().map(|(_, weight)| weight).sum()
}

fn take(entries: &mut Vec<(u8, u64)>, key: u8) -> Option<(u8, u64)> {
    let at = entries.iter().position(|(held, _)| *held == key)?;
    Some(entries.remove(at))
}

impl Model {
    fn limit(&self) -> u64 {
        let most = 4 * self.capacity / 5;
        if self.working_set > self.capacity {
            return most;
        }
        most.min(self.capacity - self.working_set)
    }

    fn settle(&mut self) {
        while weight(&self.protected) > self.limit() {
            let oldest = self.protected.remove(0);
            self.probation.push(oldest);
        }
        while weight(&self.protected) + weight(&self.probation) > self.capacity {
            self.probation.remove(0);
        }
    }

    fn get(&mut self, key: u8) -> Option<u64> {
        let found = match take(&mut self.protected, key) {
            Some(found) => found,
            None => take(&mut self.probation, key)?,
        };
        let segment =
            if found.1 <= self.limit() { &mut self.protected } else { &mut self.probation };
        segment.push(found);
        self.settle();
        Some(found.1)
    }

    fn insert(&mut self, key: u8, heavy: u64, rank: Rank) {
        let was_protected = take(&mut self.protected, key).is_some();
        take(&mut self.probation, key);
        if (was_protected || rank == Rank::Upper) && heavy <= self.limit() {
            self.protected.push((key, heavy));
        } else if heavy <= self.capacity - self.limit() {
            self.probation.push((key, heavy));
        }
        self.settle();
    }
}

fn held(segment: &Segment<u8, u64>) -> Vec<(u8, u64)> {
    segment.entries.iter().rev().map(|(key, entry)| (*key, entry.weight)).collect()
}

#[derive(Clone, Copy, Debug)]
enum Step {
    Get(u8),
    Insert(u8, u64, Rank),
    Remove(u8),
    WorkingSet(u64),
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    let key = 0..24_u8;
    // Weightless ones, ones near the shares of the segments, ones that are too heavy.
    let weights = prop_oneof![0..30_u64, 18..22_u64, 78..82_u64, 99..103_u64];
    let rank = prop_oneof![4 => Just(Rank::Detail), 1 => Just(Rank::Upper)];
    let step = prop_oneof![
        5 => key.clone().prop_map(Step::Get),
        5 => (key.clone(), weights, rank).prop_map(|(k, w, r)| Step::Insert(k, w, r)),
        1 => key.prop_map(Step::Remove),
        1 => prop_oneof![0..130_u64, Just(u64::MAX)].prop_map(Step::WorkingSet),
    ];
    proptest::collection::vec(step, 0..200)
}

proptest! {
    #[test]
    fn it_does_what_the_model_does(
        steps in steps(),
        capacity in prop_oneof![Just(100_u64), 0..130_u64],
    ) {
        let mut list = SegmentedLru::new(capacity);
        let mut model = Model { capacity, ..Model::default() };
        for step in steps {
            match step {
                Step::Get(key) => prop_assert_eq!(list.get(&key).copied(), model.get(key)),
                Step::Insert(key, weight, rank) => {
                    list.insert(key, weight, weight, rank);
                    model.insert(key, weight, rank);
                }
                Step::Remove(key) => {
                    list.remove(&key);
                    take(&mut model.probation, key);
                    take(&mut model.protected, key);
                }
                Step::WorkingSet(weight) => {
                    list.set_working_set(weight);
                    model.working_set = weight;
                    model.settle();
                }
            }
            let (probation, protected) = (held(&list.probation), held(&list.protected));
            prop_assert_eq!(&probation, &model.probation, "after {:?}", step);
            prop_assert_eq!(&protected, &model.protected, "after {:?}", step);
            // Beyond what the model shares with it: the sums, and what each segment is promised.
            prop_assert_eq!(list.probation.weight, weight(&probation));
            prop_assert_eq!(list.protected.weight, weight(&protected));
            prop_assert!(list.weight() <= capacity);
            if model.working_set <= capacity {
                prop_assert!(capacity - list.protected.weight >= model.working_set);
            }
        }
    }

    /// The floor of probation, seen from outside: whatever was used twice before, a
    /// working set of new entries stays until as much again has come.
    #[test]
    fn a_working_set_of_new_entries_stays(
        before in steps(),
        working_set in 1..=100_u64,
    ) {
        let mut list = SegmentedLru::new(100);
        for step in before {
            match step {
                Step::Get(key) => _ = list.get(&key),
                Step::Insert(key, weight, rank) => list.insert(key, weight, weight, rank),
                Step::Remove(_) | Step::WorkingSet(_) => {}
            }
        }
        list.set_working_set(working_set);
        let keys: Vec<u8> = (100..100 + working_set as u8).collect();
        for &key in &keys {
            list.insert(key, 1, 1, Rank::Detail);
        }
        for key in &keys {
            prop_assert_eq!(list.get(key), Some(&1), "of {}", working_set);
        }
    }
}

/// Share of hits of a walk there and back: view `v` uses, one after the other, the parts `v` to
/// `v + view_parts`, and the `coarse` ones, which every view uses.
fn hits(list: &mut SegmentedLru<u32, ()>, view_parts: u32, coarse: u32) -> f64 {
    let (mut hits, mut uses) = (0, 0);
    for view in (0..400).chain((0..400).rev()) {
        let parts = (view..view + view_parts).map(|part| (part, Rank::Detail));
        let coarse = (0..coarse).map(|part| (1_000_000 + part, Rank::Upper));
        for (part, rank) in coarse.chain(parts) {
            uses += 1;
            if list.get(&part).is_some() {
                hits += 1;
            } else {
                list.insert(part, (), 1, rank);
            }
        }
    }
    f64::from(hits) / f64::from(uses)
}

/// Share of hits where a view uses 110 parts, 10 of them coarse.
fn walk(capacity: u64, working_set: u64) -> f64 {
    let mut list = SegmentedLru::new(capacity);
    list.set_working_set(working_set);
    hits(&mut list, 100, 10)
}

#[test]
fn probation_must_hold_a_view() {
    // All of the capacity on probation is a plain list.
    let (ours, plain) = (walk(160, 110), walk(160, 160));
    assert!(ours > 0.95 && ours >= plain, "{ours} against {plain}");
    // Half a view fits into what is left by a protected segment that was filled elsewhere.
    let mut starved = SegmentedLru::new(160);
    for part in 2_000_000..2_000_110 {
        starved.insert(part, (), 1, Rank::Upper);
    }
    let starved = hits(&mut starved, 100, 10);
    assert!(starved < 0.2, "{starved}: the floor would not be needed");
}

#[test]
fn where_no_view_fits_the_coarse_levels_stay() {
    let (ours, plain) = (walk(80, 110), walk(80, 80));
    assert!(plain < 0.01, "{plain}: a plain list would do");
    // The coarse ones are an eleventh of what is used.
    assert!(ours > 0.09, "{ours}");
}
