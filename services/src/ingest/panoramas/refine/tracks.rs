//! The same place in several photographs.

use std::collections::HashMap;

/// A corner of a photograph: their indices.
pub(super) type Sighting = (u32, u32);

/// Fewer photographs of a place do not check each other: any two rays nearly meet.
const FEWEST: usize = 3;

/// Joins pairs of sightings to tracks, each of at least three photographs. Those that would hold two
/// corners of one photograph are wrong somewhere and left out.
pub(super) fn tracks(pairs: &[(Sighting, Sighting)]) -> Vec<Vec<Sighting>> {
    let mut indices: HashMap<Sighting, usize> = HashMap::new();
    let mut sightings: Vec<Sighting> = Vec::new();
    let mut above: Vec<usize> = Vec::new();
    for (a, b) in pairs {
        let [a, b] = [a, b].map(|sighting| {
            *indices.entry(*sighting).or_insert_with(|| {
                sightings.push(*sighting);
                above.push(above.len());
                above.len() - 1
            })
        });
        let (a, b) = (root(&mut above, a), root(&mut above, b));
        above[a.max(b)] = a.min(b);
    }
    let mut found: Vec<Vec<Sighting>> = vec![Vec::new(); above.len()];
    for (index, sighting) in sightings.iter().enumerate() {
        found[root(&mut above, index)].push(*sighting);
    }
    for track in &mut found {
        track.sort_unstable();
    }
    found.retain(|track| {
        track.len() >= FEWEST && track.windows(2).all(|pair| pair[0].0 != pair[1].0)
    });
    found
}

fn root(above: &mut [usize], mut index: usize) -> usize {
    while above[index] != index {
        above[index] = above[above[index]];
        index = above[index];
    }
    index
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_are_joined_and_contradictions_left_out() {
        let chain = [((0, 5), (1, 6)), ((2, 7), (1, 6)), ((3, 1), (2, 7))];
        assert_eq!(tracks(&chain), [vec![(0, 5), (1, 6), (2, 7), (3, 1)]]);
        let twice = [((0, 5), (1, 6)), ((1, 6), (2, 7)), ((2, 7), (0, 4))];
        assert_eq!(tracks(&twice), Vec::<Vec<Sighting>>::new());
        assert_eq!(tracks(&[((0, 5), (1, 6))]), Vec::<Vec<Sighting>>::new(), "two are too few");
    }
}
