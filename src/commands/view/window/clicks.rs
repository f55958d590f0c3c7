//! What clicks lead to.

use std::time::Instant;

use flaneur_services::place::{Found, Record};
use glam::{DVec2, DVec3};

use super::{App, Told};
use crate::commands::view::measuring::Stored;
use crate::commands::view::opened::nearest;
use crate::commands::view::painter::{Click, Order, Purpose};
use crate::commands::view::place::Place;
use crate::exit::Exit;

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
    pub(super) fn picked(&mut self, click: &Click, found: Option<Found>) {
        let Some(open) = &mut self.open else { return };
        let place = found.as_ref().map(|found| Place::met(&click.view, &found.picked));
        if place.is_none() && click.purpose != Purpose::Photograph {
            open.panels.say("nothing was surveyed there".to_owned());
        }
        match (click.purpose, place) {
            (Purpose::Measure(round), place) => {
                let measuring = &mut open.panels.measuring;
                let number = measuring.take(round, place);
                if let Some(measured) = measuring.measurement() {
                    tracing::debug!(distance_m = measured.distance, "measured");
                }
                if let Some((number, found)) = number.zip(found) {
                    self.scene.look_up(number, found, &self.proxy);
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

    /// What is stored of a marked place, or why that is not known.
    pub(super) fn learn(&mut self, number: usize, stored: Result<Record, Exit>) {
        let Some(open) = &mut self.open else { return };
        let measuring = &mut open.panels.measuring;
        match stored {
            Ok(record) => {
                let (photographs, point) = (record.photographs.len(), record.point.as_ref());
                let source = point.map(|point| point.source.as_str());
                let footprint = record.footprint.as_deref();
                tracing::debug!(photographs, source, footprint, "placed");
                measuring.learn(number, Stored::Known(Box::new(record)));
            }
            Err(exit) => {
                measuring.learn(number, Stored::Unknown);
                self.say(format!("what is stored of the place cannot be had: {}", exit.message()));
            }
        }
    }

    /// Looks for the photograph nearest to a place, to go there.
    pub(super) fn find_photograph(&self, near: DVec3) {
        let (client, proxy) = (self.scene.streamer.client().clone(), self.proxy.clone());
        tokio::spawn(async move {
            let found = nearest(&client, near.truncate()).await;
            drop(proxy.send_event(Told::Photograph(found)));
        });
    }
}
