//! Along walls, not through them: the web page's rule, see services/web/src/motion/slide.ts.

use glam::DVec2;

use crate::commands::view::buildings::Walls;

/// One comes no nearer to a wall than about that, metres.
const CLEARANCE: f64 = 1.0;
/// So far one is turned aside to go along a wall, degrees; who walks into it straight on stands still.
const ASIDE: [f64; 9] = [0.0, 15.0, -15.0, 30.0, -30.0, 45.0, -45.0, 60.0, -60.0];

/// A step in plan that enters no building: where it would, what is left of it beside the wall. Who is
/// inside already, as beneath an arch, goes freely.
pub(super) fn slid(from: DVec2, step: DVec2, walls: &impl Walls) -> DVec2 {
    let length = step.length();
    if length == 0.0 || walls.contain(from) {
        return step;
    }
    let ways = ASIDE.map(|aside| {
        let (sin, cos) = aside.to_radians().sin_cos();
        // Clockwise.
        (DVec2::new(cos, -sin).rotate(step / length), length * cos)
    });
    let free = |&&(way, metres): &&(DVec2, f64)| {
        // A long step must not lead through a thin house.
        let mut at = metres + CLEARANCE;
        while at > 0.0 {
            if walls.contain(from + way * at) {
                return false;
            }
            at -= CLEARANCE;
        }
        true
    };
    ways.iter().find(free).map_or(DVec2::ZERO, |&(way, metres)| way * metres)
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::*;

    /// Those of the page, too.
    const CASES: &str = include_str!("../../../../services/web/src/motion/slide.cases.json");

    struct Houses(Vec<[f64; 4]>);

    impl Walls for Houses {
        fn contain(&self, DVec2 { x, y }: DVec2) -> bool {
            self.0
                .iter()
                .any(|&[west, south, east, north]| west < x && x < east && south < y && y < north)
        }
    }

    fn numbers<const N: usize>(value: &Value) -> [f64; N] {
        std::array::from_fn(|index| value[index].as_f64().expect("a number"))
    }

    #[test]
    fn one_goes_beside_walls_as_on_the_page() {
        let cases: Value = serde_json::from_str(CASES).expect("JSON");
        let houses = cases["houses"].as_array().expect("houses");
        let houses = Houses(houses.iter().map(numbers).collect());
        let steps = cases["steps"].as_array().expect("steps");
        assert!(steps.len() > 5);
        for case in steps {
            let vector = |name: &str| DVec2::from_array(numbers(&case[name]));
            let gone = slid(vector("from"), vector("step"), &houses);
            assert!(gone.distance(vector("goes")) < 1e-5, "{}: {gone}", case["what"]);
        }
    }
}
