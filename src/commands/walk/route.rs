//! Where someone is who walks from view to view.

use flaneur_scene::View;

use crate::viewpoints::{Height, Listed, Size, Viewpoint};

/// The longest walk, seconds.
const MAX_S: f64 = 3600.0;
/// How fast one turns where one does not walk, or walks too little for it, degrees a second: a look
/// around takes four seconds.
const TURN_DEG_S: f64 = 90.0;

/// A walk: views, and when each is reached.
#[derive(Clone, Debug)]
pub(super) struct Route {
    start: Stop,
    /// Those after it, in the order of time.
    stops: Vec<Stop>,
    size: Size,
}

/// A view, and when it is reached, seconds.
type Stop = (f64, Viewpoint);

impl Route {
    /// The walk through `listed` at their times, where they have them, else at `speed_m_s`.
    ///
    /// # Errors
    /// Says what is wrong with which view: times that some views lack, that go back, or that are out
    /// of range; a walk that is too long.
    pub(super) fn new(
        listed: &[Listed],
        speed_m_s: f64,
        fov_deg: f64,
        size: Size,
    ) -> Result<Self, String> {
        let timed = listed.iter().any(|view| view.time_s.is_some());
        let mut stops: Vec<Stop> = Vec::with_capacity(listed.len());
        for (index, view) in listed.iter().enumerate() {
            let bad = |problem: String| format!("view {}: {problem}", index + 1);
            let viewpoint = view.viewpoint.or_fov(fov_deg);
            let before = stops.last();
            let time_s = match (timed, view.time_s, before) {
                (true, None, _) => {
                    return Err(bad("it has no \"time_s\", though others have one".to_owned()));
                }
                (true, Some(time_s), _) => time_s,
                (false, _, None) => 0.0,
                (false, _, Some((left_s, from))) => {
                    let (distance_m, turn_deg) = from.way_to(&viewpoint);
                    left_s + (distance_m / speed_m_s).max(turn_deg / TURN_DEG_S)
                }
            };
            let earliest_s = before.map_or(0.0, |(left_s, _)| *left_s);
            if !(time_s >= earliest_s) {
                return Err(bad(format!("\"time_s\" is {time_s}, must be at least {earliest_s}")));
            }
            if time_s > MAX_S {
                return Err(bad(format!(
                    "it is reached after {time_s:.0} s, a walk takes at most {MAX_S} s; take fewer \
                     views, or walk faster"
                )));
            }
            stops.push((time_s, viewpoint));
        }
        let mut stops = stops.into_iter();
        let start = stops.next().ok_or("it holds no view")?;
        Ok(Self { start, stops: stops.collect(), size })
    }

    /// When the last view is reached, seconds.
    pub(super) fn end_s(&self) -> f64 {
        self.stops.last().unwrap_or(&self.start).0
    }

    /// What is seen at a time, seconds: before the first stop that one, after the last the last.
    pub(super) fn view(&self, time_s: f64) -> View {
        let mut viewpoint = self.start.1;
        let (mut left_s, mut from) = self.start;
        for &(reached_s, to) in &self.stops {
            if time_s < left_s {
                break;
            }
            let share =
                if time_s < reached_s { (time_s - left_s) / (reached_s - left_s) } else { 1.0 };
            viewpoint = from.towards(&to, share);
            (left_s, from) = (reached_s, to);
        }
        // Each has a field of view of its own.
        viewpoint.view(Height::Degrees(f64::NAN), Some(self.size), self.size)
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, UVec2};

    use super::*;

    const SIZE: Size = Size(UVec2::new(64, 32));

    fn listed(x: f64, heading: f64, time_s: Option<f64>) -> Listed {
        let viewpoint = format!("{x},0,2,{heading},0").parse().expect("a view");
        Listed { viewpoint, file: None, time_s }
    }

    fn route(views: &[Listed]) -> Result<Route, String> {
        Route::new(views, 1.4, 60.0, SIZE)
    }

    #[test]
    fn someone_walks_at_the_speed_and_turns_on_the_spot() {
        let views = [listed(0.0, 90.0, None), listed(14.0, 90.0, None), listed(14.0, 270.0, None)];
        let route = route(&views).expect("good");
        assert!((route.end_s() - 12.0).abs() < 1e-9, "ten to walk, two to turn: {}", route.end_s());
        let eye = |time_s: f64| route.view(time_s).eye();
        assert!(eye(2.5).distance(DVec3::new(3.5, 0.0, 2.0)) < 1e-9);
        assert!(
            route.view(11.0).camera.forward().distance(DVec3::Y) < 1e-9
                || route.view(11.0).camera.forward().distance(DVec3::NEG_Y) < 1e-9
        );
        assert_eq!(route.view(12.0), route.view(1e9));
        assert_eq!(route.view(3.0).size(), SIZE.0);
    }

    #[test]
    fn times_are_kept_and_one_stands_before_the_first() {
        let views =
            [listed(0.0, 0.0, Some(2.0)), listed(8.0, 0.0, Some(4.0)), listed(9.0, 0.0, Some(4.0))];
        let route = route(&views).expect("good");
        assert_eq!(route.view(0.0), route.view(2.0));
        assert_eq!(route.view(3.0).eye().x, 4.0);
        assert_eq!((route.view(4.0).eye().x, route.end_s()), (9.0, 4.0));
    }

    #[test]
    fn what_is_no_walk_is_said() {
        let at = |time_s: Option<f64>| listed(0.0, 0.0, time_s);
        let fault = |views: &[Listed]| route(views).expect_err("bad");
        assert!(fault(&[at(Some(0.0)), at(None)]).contains("view 2: it has no"));
        assert!(fault(&[at(Some(5.0)), at(Some(4.0))]).contains("view 2: \"time_s\" is 4"));
        assert!(fault(&[at(Some(-1.0))]).contains("at least 0"));
        assert!(fault(&[at(Some(f64::NAN))]).contains("NaN"));
        assert!(fault(&[at(Some(1e9))]).contains("at most 3600"));
        assert!(fault(&[listed(0.0, 0.0, None), listed(1e6, 0.0, None)]).contains("view 2"));
        assert!(fault(&[]).contains("no view"));
    }
}
