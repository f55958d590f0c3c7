//! What a cadastre and a terrain model know of the street: boxes and spot heights.

use glam::{DVec2, DVec3};
use rand::RngExt;
use serde_json::{Value, json};

use crate::camera::rounded;
use crate::frame::StreetFrame;
use crate::street::{Building, Purpose, Street, random};

/// How far a wall may be from its footprint, as published, metres.
pub(crate) const UNCERTAINTY_M: f64 = 0.5;
/// Distance between spot heights, metres, and how far they may be off.
const SPOT_SPACING_M: f64 = 6.0;
const SPOT_ERROR_M: f64 = 0.03;
/// How far beyond the block the spot heights go.
const SPOT_MARGIN_M: f64 = 48.0;

/// The footprints as GeoJSON in EPSG:2154, heights in metres above the ground.
pub(crate) fn footprints(street: &Street) -> Value {
    let features = street.buildings.iter().enumerate().map(|(index, building)| {
        let mut ring: Vec<[f64; 2]> = building.outline.iter().map(|&p| plan(building, p)).collect();
        ring.push(ring[0]);
        json!({
            "type": "Feature",
            "id": id(index),
            "geometry": { "type": "Polygon", "coordinates": [ring] },
            "properties": {
                "id": id(index),
                "height": rounded(building.height_m, 1),
                "source": "cadastre",
            },
        })
    });
    json!({
        "type": "FeatureCollection",
        "crs": { "type": "name", "properties": { "name": "urn:ogc:def:crs:EPSG::2154" } },
        "features": features.collect::<Vec<_>>(),
    })
}

/// What the footprints got wrong, building by building.
pub(crate) fn footprint_truth(street: &Street) -> Value {
    let of = |(index, building): (usize, &Building)| {
        json!({
            "id": id(index),
            "facade_offset_m": building.facade_offset_m,
            "base_m": StreetFrame::PLACE.world_from_point(DVec3::Z * building.base_m).z,
            "height_m": rounded(building.height_m, 1),
            "eaves_m": building.eaves_m,
        })
    };
    Value::Array(street.buildings.iter().enumerate().map(of).collect())
}

/// Spot heights of the ground, `[{"e", "n", "h"}, …]`, each up to 3 cm off.
pub(crate) fn spot_heights(street: &Street, seed: u64) -> Value {
    let mut rng = random(seed, Purpose::Drive, 0);
    let columns = ((street.length_m + 2.0 * SPOT_MARGIN_M) / SPOT_SPACING_M).ceil() as u32;
    let mut spots = Vec::new();
    for column in 0..=columns {
        let x = -SPOT_MARGIN_M + f64::from(column) * SPOT_SPACING_M;
        // Both sides of the kerbs, the facades, and beyond.
        for y in [-44.0, -26.0, -14.0, -7.8, -4.9, -4.3, 0.0, 4.3, 4.9, 7.8, 14.0, 26.0, 44.0] {
            let error = rng.random_range(-SPOT_ERROR_M..SPOT_ERROR_M);
            let height = street.terrain.height(x, y) + error;
            let p = StreetFrame::PLACE.world_from_point(DVec3::new(x, y, height));
            spots.push(json!({
                "e": rounded(p.x, 2), "n": rounded(p.y, 2), "h": rounded(p.z, 2),
            }));
        }
    }
    Value::Array(spots)
}

fn id(index: usize) -> String {
    format!("building-{:04}", index + 1)
}

fn plan(building: &Building, p: DVec2) -> [f64; 2] {
    let p = StreetFrame::PLACE.world_from_point(p.extend(building.base_m));
    [rounded(p.x, 3), rounded(p.y, 3)]
}
