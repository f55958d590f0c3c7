//! In which order parts are fetched.
//!
//! A picture's error is what it lacks of the signal. Photographs of streets have about as much
//! energy in every octave of spatial frequency, so that an image which misses *k* octaves that the
//! view could show lacks *k* units where it decides the picture, and a new level gains one unit
//! an octave, times the image's share of the picture. Points gain by where they put
//! photographs: what is seen from elsewhere than the eye is displaced by the parallax of the depth
//! that is not known, and wrong in the octaves that are finer than that. ARCHITECTURE.md derives both. What
//! gains most a byte comes first.

use std::collections::HashMap;

use super::clusters::{self, Job};
use super::part::{Part, Stage, Want};

/// Which parts come first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// Those that lower the expected error of the picture most a byte.
    #[default]
    ExpectedError,
    /// The nearest, coarse before fine: what the other is measured against.
    NearestFirst,
}

/// Sorts `wants`, given with what must come first before what follows it: stages one after the other,
/// and within each by `order`, but levels of an image from coarse to fine. By expected error something
/// that gains little alone comes early where what must wait for it gains much, see [`clusters`]; nodes wait for
/// none, and come after those above them only where the nearest come first.
pub(super) fn sort(wants: &mut Vec<Want>, order: Order) {
    let mut places: HashMap<Part, usize> = HashMap::new();
    let mut stages: Vec<Stage> = Vec::with_capacity(wants.len());
    let mut after: Vec<Option<usize>> = Vec::with_capacity(wants.len());
    for (index, want) in wants.iter().enumerate() {
        let above = predecessor(&want.part, order, |part| places.get(part).copied());
        let stage = above.map_or(want.stage, |above| want.stage.max(stages[above]));
        // What comes in an earlier stage is there anyway.
        after.push(above.filter(|&above| stages[above] == stage));
        stages.push(stage);
        places.insert(slot(&want.part), index);
    }
    let mut sequence: Vec<usize> = match order {
        Order::ExpectedError => {
            let jobs = wants.iter().zip(&after).map(|(want, &after)| Job {
                gain: want.gain,
                cost: want.bytes.max(1) as f64,
                after,
            });
            clusters::order(&jobs.collect::<Vec<Job>>())
        }
        Order::NearestFirst => {
            let mut farthest_m: Vec<f64> = Vec::with_capacity(wants.len());
            for (want, after) in wants.iter().zip(&after) {
                let own = if want.part.is_survey() { f64::NEG_INFINITY } else { want.distance_m };
                farthest_m.push(after.map_or(own, |above| own.max(farthest_m[above])));
            }
            let mut sequence: Vec<usize> = (0..wants.len()).collect();
            sequence.sort_by(|&a, &b| farthest_m[a].total_cmp(&farthest_m[b]));
            sequence
        }
    };
    sequence.sort_by_key(|&index| stages[index]);
    let mut left: Vec<Option<Want>> = wants.drain(..).map(Some).collect();
    wants.extend(sequence.into_iter().filter_map(|index| left[index].take()));
}

/// What parts that follow each other share: the level of an image is left out.
fn slot(part: &Part) -> Part {
    match part {
        Part::Image { panorama, camera, .. } => {
            Part::Image { panorama: panorama.clone(), camera: *camera, level: 0 }
        }
        other => other.clone(),
    }
}

/// What is known of the part that must come before `part`.
fn predecessor<T>(part: &Part, order: Order, known: impl Fn(&Part) -> Option<T>) -> Option<T> {
    match part {
        Part::Image { .. } => known(&slot(part)),
        Part::Node(id) if order == Order::NearestFirst => {
            let mut above = id.key.parent();
            while let Some(key) = above {
                let found = known(&Part::Node(flaneur_scene::PointNodeId { key, ..*id }));
                if found.is_some() {
                    return found;
                }
                above = key.parent();
            }
            None
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flaneur_scene::{NodeKey, PointNodeId};

    fn want(part: Part, stage: Stage, gain: f64, bytes: u64, distance_m: f64) -> Want {
        Want { part, stage, bytes, gain, distance_m, photographs: [].into(), exact: true }
    }

    fn node(key: NodeKey, gain: f64, bytes: u64) -> Want {
        let part = Part::Node(PointNodeId { source: 0, key });
        want(part, Stage::Detail, gain, bytes, 1.0)
    }

    fn image(name: &str, level: u32, stage: Stage, gain: f64, bytes: u64) -> Want {
        let part = Part::Image { panorama: name.into(), camera: 0, level };
        want(part, stage, gain, bytes, 2.0)
    }

    fn sorted(mut wants: Vec<Want>, order: Order) -> Vec<Part> {
        sort(&mut wants, order);
        wants.into_iter().map(|want| want.part).collect()
    }

    #[test]
    fn what_gains_most_a_byte_comes_first_after_what_it_builds_on() {
        let below = NodeKey::ROOT.children()[3];
        let wants = vec![
            node(NodeKey::ROOT, 1.0, 100),
            // It needs nothing of the node above it.
            node(below, 50.0, 100),
            image("a", 4, Stage::First, 0.1, 100),
            image("a", 2, Stage::Detail, 300.0, 1000),
            image("b", 2, Stage::Detail, 1.0, 1000),
        ];
        let order = sorted(wants.clone(), Order::ExpectedError);
        let expected = [2, 1, 3, 0, 4].map(|i: usize| wants[i].part.clone());
        assert_eq!(order, expected);
    }

    #[test]
    fn nearest_first_goes_by_distance_alone() {
        let wants = vec![
            image("a", 2, Stage::Detail, 30.0, 10),
            node(NodeKey::ROOT, 1.0, 1000),
            Want { distance_m: 0.5, ..node(NodeKey::ROOT.children()[0], 0.0, 1) },
        ];
        let order = sorted(wants.clone(), Order::NearestFirst);
        assert_eq!(order, [1, 2, 0].map(|i: usize| wants[i].part.clone()));
    }
}
