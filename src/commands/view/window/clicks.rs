//! What clicks lead to.

use std::time::Instant;

use flaneur_renderer::Sight;
use glam::{DVec2, DVec3};

use super::{App, Told};
use crate::commands::view::opened::{nearest, taken_at};
use crate::commands::view::painter::{Click, Order, Purpose};
use crate::commands::view::place::Place;

/// Panoramas are looked for so much farther than a photograph says, metres: a camera is not its rig.
const SLACK_M: f64 = 10.0;

impl App {
    /// Someone clicks at a pixel of what is shown now.
    pub(super) fn click(&mut self, pixel: DVec2, double: bool) {
        let Some(open) = &mut self.open else { return };
        let measuring = &mut open.panels.measuring;
        let purpose = if measuring.is_on() {
            // Two places may well lie close to each other.
            Purpose::Measure(measuring.ask())
        } else if double {
            Purpose::Photograph
        } else {
            Purpose::Go
        };
        let view = self.visitor.pose().view(open.screen.size());
        self.painter.order(Order::Pick(Box::new(Click { view, pixel, purpose })));
    }

    /// A click met a place, or nothing that was surveyed.
    pub(super) fn picked(&mut self, click: &Click, place: Option<Place>) {
        let Some(open) = &mut self.open else { return };
        if place.is_none() && click.purpose != Purpose::Photograph {
            open.panels.say("nothing was surveyed there".to_owned());
        }
        match (click.purpose, place) {
            (Purpose::Measure(round), place) => {
                let measuring = &mut open.panels.measuring;
                measuring.take(round, place);
                tracing::debug!(photographs = measuring.sights().len(), "placed");
                if let Some(measured) = measuring.measurement() {
                    tracing::debug!(distance_m = measured.distance, "measured");
                }
            }
            (Purpose::Photograph, place) => {
                self.find_photograph(place.map_or(click.view.eye(), |place| place.position));
            }
            (Purpose::Go, Some(place)) => {
                self.visitor.go_to(&place, Instant::now(), &self.painter.ground());
            }
            (Purpose::Go, None) => {}
        }
    }

    /// Looks for where a photograph was taken that sees a place, to go there and look at it.
    pub(super) fn find_taken(&self, sight: Sight, place: DVec3) {
        let (client, proxy) = (self.scene.client.clone(), self.proxy.clone());
        tokio::spawn(async move {
            let reach_m = sight.distance_m + SLACK_M;
            let centre = taken_at(&client, &sight.id, place.truncate(), reach_m).await;
            drop(proxy.send_event(Told::Taken(centre, place)));
        });
    }

    /// Looks for the photograph nearest to a place, to go there.
    pub(super) fn find_photograph(&self, near: DVec3) {
        let (client, proxy) = (self.scene.client.clone(), self.proxy.clone());
        tokio::spawn(async move {
            let found = nearest(&client, near.truncate()).await;
            drop(proxy.send_event(Told::Photograph(found)));
        });
    }
}
