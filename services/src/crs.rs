//! Coordinate reference systems: projected ones by EPSG code, and plain local metres.
//!
//! A scene keeps the coordinates of its survey; nothing here moves them. A CRS is asked for two
//! things only: where grid north lies, to turn headings given from true north, and where on
//! Earth a point is, to show it on a map.

use std::fmt;

use glam::{DVec2, DVec3};
use proj4rs::Proj;
use proj4rs::adaptors::{transform_xy, transform_xyz};

/// Half the step along the meridian for [`Crs::meridian_convergence`], radians (64 m on the
/// ground): short enough that the curvature of the projected meridian cancels to 1e-9 rad in the
/// central difference, long enough that the rounding of northings near 1e7 m stays below 1e-10.
const MERIDIAN_STEP: f64 = 1e-5;

/// The frame of a scene's coordinates: metres, x east, y north, z up.
#[derive(Clone)]
pub struct Crs(Kind);

#[derive(Clone)]
enum Kind {
    Projected(Box<Projected>),
    Local { geographic_origin: Option<[f64; 3]> },
}

#[derive(Clone)]
struct Projected {
    code: u16,
    definition: &'static str,
    name: &'static str,
    grid: Proj,
    /// Longitude and latitude on the ellipsoid of `grid`, without change of datum.
    geographic: Proj,
    wgs84: Proj,
}

/// Why a CRS cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CrsError {
    /// Neither `EPSG:n` nor `local`.
    #[error("CRS {text:?} is not understood; write \"EPSG:\" and a code, or \"local\"")]
    Syntax {
        /// What was written.
        text: String,
    },
    /// The code is not in the table.
    #[error(
        "EPSG:{code} is not a known projected CRS; use the code of a projected CRS in metres, or \"local\""
    )]
    Unknown {
        /// The code.
        code: u32,
    },
    /// The definition needs something that is not there.
    #[error(
        "EPSG:{code} cannot be set up ({reason}); convert the survey to another projected CRS, or use \"local\""
    )]
    Unsupported {
        /// The code.
        code: u32,
        /// What the projection library said.
        reason: String,
    },
    /// Degrees, or geocentric coordinates.
    #[error(
        "EPSG:{code} is not a projected CRS (its coordinates are {coordinates}); convert the survey to a projected CRS in metres, such as the UTM zone around it"
    )]
    NotProjected {
        /// The code.
        code: u32,
        /// What its coordinates are.
        coordinates: &'static str,
    },
    /// Feet, or axes that are not east and north.
    #[error(
        "EPSG:{code} has {what}; convert the survey to a CRS in metres with x east and y north"
    )]
    AxesOrUnits {
        /// The code.
        code: u32,
        /// What is not as it should be.
        what: String,
    },
    /// A geographic origin out of range.
    #[error(
        "geographic_origin {origin:?} is not [latitude, longitude, height]: latitude within ±90, longitude within ±180 degrees, height in metres"
    )]
    Origin {
        /// What was given.
        origin: [f64; 3],
    },
    /// A geographic origin beside a projected CRS.
    #[error("geographic_origin goes with crs = \"local\" only, not with EPSG:{code}; remove it")]
    NeedlessOrigin {
        /// The code.
        code: u32,
    },
    /// A local CRS that says nowhere where it is.
    #[error(
        "a local CRS without geographic_origin has no place on Earth; add geographic_origin = [latitude, longitude, height]"
    )]
    NoOrigin,
    /// A point where the projection is not defined.
    #[error(
        "EPSG:{code} is not defined at ({x}, {y}): {reason}; check the coordinates and the CRS"
    )]
    OutOfRange {
        /// The code.
        code: u32,
        /// Easting, metres.
        x: f64,
        /// Northing, metres.
        y: f64,
        /// What the projection library said.
        reason: String,
    },
}

impl Crs {
    /// The CRS named `EPSG:n` (any case), or `local`: metres in a frame tangent at
    /// `geographic_origin` (latitude, longitude in degrees on WGS 84, ellipsoidal height in metres), x
    /// east, y north, z up there.
    ///
    /// # Errors
    ///
    /// What is not a projected CRS in metres with x east and y north is refused.
    pub fn parse(text: &str, geographic_origin: Option<[f64; 3]>) -> Result<Self, CrsError> {
        if text.eq_ignore_ascii_case("local") {
            if let Some(origin @ [latitude, longitude, height]) = geographic_origin
                && !(latitude.abs() <= 90.0 && longitude.abs() <= 180.0 && height.is_finite())
            {
                return Err(CrsError::Origin { origin });
            }
            return Ok(Self(Kind::Local { geographic_origin }));
        }
        let code = text
            .split_once(':')
            .filter(|(authority, _)| authority.eq_ignore_ascii_case("EPSG"))
            .and_then(|(_, code)| code.parse::<u32>().ok())
            .ok_or_else(|| CrsError::Syntax { text: text.to_owned() })?;
        if geographic_origin.is_some() {
            return Err(CrsError::NeedlessOrigin { code });
        }
        Projected::new(code).map(|projected| Self(Kind::Projected(Box::new(projected))))
    }

    /// The EPSG code, `None` for a local CRS.
    pub fn epsg(&self) -> Option<u16> {
        match &self.0 {
            Kind::Projected(projected) => Some(projected.code),
            Kind::Local { .. } => None,
        }
    }

    /// What people call it, as in `RGF93 / Lambert-93`; `None` for a local CRS.
    pub fn name(&self) -> Option<&'static str> {
        match &self.0 {
            Kind::Projected(projected) => Some(projected.name),
            Kind::Local { .. } => None,
        }
    }

    /// Whether `code` names a CRS with the same plan coordinates: this one, or one that adds a
    /// vertical datum to it, as EPSG:7415 does to EPSG:28992.
    pub fn has_plan_of(&self, code: u32) -> bool {
        let Kind::Projected(own) = &self.0 else { return false };
        let definition = u16::try_from(code).ok().and_then(crs_definitions::from_code);
        u32::from(own.code) == code
            || definition.is_some_and(|other| plan(other.proj4).eq(plan(own.definition)))
    }

    /// The meridian convergence at a point of the plan: the angle in radians from true north to
    /// grid north, positive clockwise (grid north lies east of true north). Hence
    /// `heading_grid = heading_true − convergence`.
    ///
    /// In Lambert-93, east of 3° E it is positive, in Paris about −0.48°. It is taken from the
    /// projection itself by a central difference along the meridian; its error is below
    /// 1e-8 rad. A local CRS is aligned with true north at its origin: 0.
    ///
    /// # Errors
    ///
    /// Where the projection is not defined.
    pub fn meridian_convergence(&self, at: DVec2) -> Result<f64, CrsError> {
        let Kind::Projected(crs) = &self.0 else { return Ok(0.0) };
        let fail = |error| crs.out_of_range(at, &error);
        let (longitude, latitude) =
            transform_xy(&crs.grid, &crs.geographic, at.x, at.y).map_err(fail)?;
        let project = |latitude| {
            transform_xy(&crs.geographic, &crs.grid, longitude, latitude)
                .map(|(x, y)| DVec2::new(x, y))
        };
        let north = project(latitude + MERIDIAN_STEP).map_err(fail)?
            - project(latitude - MERIDIAN_STEP).map_err(fail)?;
        if !(north.is_finite() && north.length() > 0.0) {
            return Err(fail(proj4rs::errors::Error::CoordinateOutOfRange));
        }
        Ok((-north.x).atan2(north.y))
    }

    /// Latitude and longitude (degrees, WGS 84) and height (metres) of a world point.
    ///
    /// The height of a projected CRS is passed through: it refers to whatever surface the survey
    /// used. That of a local CRS is ellipsoidal. Where a datum is tied to WGS 84 by the seven
    /// parameters of the EPSG table, the position is good to a few metres.
    ///
    /// # Errors
    ///
    /// Where the projection is not defined, and for a local CRS without an origin.
    pub fn to_wgs84(&self, p: DVec3) -> Result<[f64; 3], CrsError> {
        match &self.0 {
            Kind::Projected(crs) => {
                let fail = |error| crs.out_of_range(p.truncate(), &error);
                let (longitude, latitude, _) =
                    transform_xyz(&crs.grid, &crs.wgs84, p.x, p.y, 0.0).map_err(fail)?;
                if !(longitude.is_finite() && latitude.is_finite()) {
                    return Err(fail(proj4rs::errors::Error::NanCoordinateValue));
                }
                Ok([latitude.to_degrees(), longitude.to_degrees(), p.z])
            }
            Kind::Local { geographic_origin: None } => Err(CrsError::NoOrigin),
            Kind::Local { geographic_origin: Some(origin) } => Ok(wgs84::from_local(*origin, p)),
        }
    }
}

impl fmt::Display for Crs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Kind::Projected(projected) => write!(f, "EPSG:{}", projected.code),
            Kind::Local { .. } => f.write_str("local"),
        }
    }
}

impl fmt::Debug for Crs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Crs({self})")
    }
}

/// The EPSG code that a CRS name of GeoJSON, CityJSON or FlatGeobuf carries: `EPSG:n`,
/// `urn:ogc:def:crs:EPSG:version:n`, `http(s)://www.opengis.net/def/crs/EPSG/version/n`.
pub fn epsg_code(name: &str) -> Option<u32> {
    let parts: Vec<&str> = name.split([':', '/']).collect();
    let authority = parts.iter().position(|part| part.eq_ignore_ascii_case("EPSG"))?;
    parts.last().filter(|_| authority + 1 < parts.len())?.parse().ok()
}

impl Projected {
    fn new(code: u32) -> Result<Self, CrsError> {
        let (short, known) = u16::try_from(code)
            .ok()
            .and_then(|short| Some((short, crs_definitions::from_code(short)?)))
            .ok_or(CrsError::Unknown { code })?;
        let definition = known.proj4;
        let unsupported = |error: proj4rs::errors::Error| CrsError::Unsupported {
            code,
            reason: error.to_string(),
        };
        let grid = Proj::from_proj_string(definition).map_err(unsupported)?;
        if grid.is_latlong() {
            return Err(CrsError::NotProjected { code, coordinates: "degrees" });
        }
        if grid.is_geocent() {
            return Err(CrsError::NotProjected { code, coordinates: "geocentric" });
        }
        if !grid.is_normalized_axis() {
            let axes = String::from_utf8_lossy(grid.axis()).into_owned();
            return Err(CrsError::AxesOrUnits { code, what: format!("the axes {axes:?}") });
        }
        if grid.to_meter() != 1.0 || grid.vto_meter() != 1.0 {
            let metres = if grid.to_meter() == 1.0 { grid.vto_meter() } else { grid.to_meter() };
            return Err(CrsError::AxesOrUnits { code, what: format!("units of {metres} m") });
        }
        let (a, b) = grid.ellipse_parameters();
        let geographic = Proj::from_proj_string(&format!("+proj=longlat +a={a} +b={b} +no_defs"))
            .map_err(unsupported)?;
        let wgs84 =
            Proj::from_proj_string("+proj=longlat +datum=WGS84 +no_defs").map_err(unsupported)?;
        // In WKT the name is the first text in quotes.
        let name = known.wkt.split('"').nth(1).unwrap_or_default();
        Ok(Self { code: short, definition, name, grid, geographic, wgs84 })
    }

    fn out_of_range(&self, at: DVec2, error: &proj4rs::errors::Error) -> CrsError {
        let code = u32::from(self.code);
        CrsError::OutOfRange { code, x: at.x, y: at.y, reason: error.to_string() }
    }
}

/// The terms of a definition that bear on plan coordinates.
fn plan(definition: &str) -> impl Iterator<Item = &str> {
    definition
        .split_ascii_whitespace()
        .filter(|term| !term.starts_with("+vunits=") && !term.starts_with("+geoidgrids="))
}

/// From a tangent plane to geographic coordinates, on the WGS 84 ellipsoid.
mod wgs84 {
    use glam::{DMat3, DVec3};

    const A: f64 = 6_378_137.0;
    const F: f64 = 1.0 / 298.257_223_563;
    const E2: f64 = F * (2.0 - F);

    /// Latitude, longitude (degrees) and ellipsoidal height (metres) of `p` in the east-north-up
    /// frame at `origin`.
    pub(super) fn from_local(origin: [f64; 3], p: DVec3) -> [f64; 3] {
        let (latitude, longitude) = (origin[0].to_radians(), origin[1].to_radians());
        let (sin_lat, cos_lat) = latitude.sin_cos();
        let (sin_lon, cos_lon) = longitude.sin_cos();
        let ecef_from_local = DMat3::from_cols(
            DVec3::new(-sin_lon, cos_lon, 0.0),
            DVec3::new(-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat),
            DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat),
        );
        geodetic(ecef(latitude, longitude, origin[2]) + ecef_from_local * p)
    }

    pub(super) fn ecef(latitude: f64, longitude: f64, height: f64) -> DVec3 {
        let (sin_lat, cos_lat) = latitude.sin_cos();
        let n = A / (1.0 - E2 * sin_lat * sin_lat).sqrt();
        DVec3::new(
            (n + height) * cos_lat * longitude.cos(),
            (n + height) * cos_lat * longitude.sin(),
            (n * (1.0 - E2) + height) * sin_lat,
        )
    }

    /// Bowring's iteration on the reduced latitude β, tan φ = (z + e'² b sin³β) / (ρ − e² a cos³β).
    /// Near the Earth's surface each step gains at least four digits: four steps reach rounding.
    fn geodetic(p: DVec3) -> [f64; 3] {
        let b = A * (1.0 - F);
        let rho = p.x.hypot(p.y);
        let mut beta = p.z.atan2((1.0 - F) * rho);
        let mut latitude = beta;
        for _ in 0..4 {
            let (sin, cos) = beta.sin_cos();
            latitude = (p.z + E2 / (1.0 - E2) * b * sin.powi(3)).atan2(rho - E2 * A * cos.powi(3));
            beta = ((1.0 - F) * latitude.sin()).atan2(latitude.cos());
        }
        let (sin, cos) = latitude.sin_cos();
        // ρ cos φ + z sin φ − a √(1 − e² sin² φ) stays exact at the poles, where ρ / cos φ does not.
        let height = rho * cos + p.z * sin - A * (1.0 - E2 * sin * sin).sqrt();
        [latitude.to_degrees(), p.y.atan2(p.x).to_degrees(), height]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn crs(name: &str) -> Crs {
        Crs::parse(name, None).expect(name)
    }

    #[test]
    fn convergence_of_lambert_93_is_that_of_the_conic() {
        // On a conformal cone γ = n (λ − λ₀), with n from the two standard parallels.
        let lambert = crs("EPSG:2154");
        let paris = DVec2::new(651_500.0, 6_861_300.0);
        let convergence = lambert.meridian_convergence(paris).expect("inside France");
        let degrees = convergence.to_degrees();
        assert!((degrees + 0.479_57).abs() < 1e-5, "atan(−48 500 / 5 794 312): {degrees}");

        let e2: f64 = 0.006_694_380_022_90; // GRS 80
        let m = |phi: f64| phi.cos() / (1.0 - e2 * phi.sin().powi(2)).sqrt();
        let t = |phi: f64| {
            let s = e2.sqrt() * phi.sin();
            (std::f64::consts::FRAC_PI_4 - phi / 2.0).tan()
                / ((1.0 - s) / (1.0 + s)).powf(e2.sqrt() / 2.0)
        };
        let (phi1, phi2) = (44f64.to_radians(), 49f64.to_radians());
        let n = (m(phi1) / m(phi2)).ln() / (t(phi1) / t(phi2)).ln();
        let [_, longitude, _] = lambert.to_wgs84(paris.extend(0.0)).expect("inside France");
        let expected = n * (longitude - 3.0).to_radians();
        assert!((convergence - expected).abs() < 1e-8, "{convergence} against {expected} rad");
    }

    #[test]
    fn convergence_of_utm_is_that_of_the_series() {
        // Transverse Mercator: tan γ = tan Δλ sin φ on the sphere; the ellipsoid adds
        // Δλ³ sin φ cos² φ (3η² + 2η⁴)/3 with η² = e'² cos² φ (Snyder's and Redfearn's series).
        let utm = crs("EPSG:32632");
        for at in [DVec2::new(300_000.0, 5_400_000.0), DVec2::new(720_000.0, 5_600_000.0)] {
            let [latitude, longitude, _] = utm.to_wgs84(at.extend(0.0)).expect("in the zone");
            let (phi, delta) = (latitude.to_radians(), (longitude - 9.0).to_radians());
            let eta2 = 0.006_739_496_742_28 * phi.cos().powi(2);
            let expected = (delta.tan() * phi.sin()).atan()
                + delta.powi(3) * phi.sin() * phi.cos().powi(2) * (3.0 * eta2 + 2.0 * eta2 * eta2)
                    / 3.0;
            let convergence = utm.meridian_convergence(at).expect("in the zone");
            // What the series leaves out is of the order of η² Δλ⁵ < 1e-9.
            assert!((convergence - expected).abs() < 1e-8, "{convergence} against {expected} rad");
        }
    }

    #[test]
    fn convergence_of_the_dutch_grid() {
        let rd = crs("EPSG:28992");
        let amersfoort = rd.meridian_convergence(DVec2::new(155_000.0, 463_000.0)).expect("origin");
        assert!(amersfoort.abs() < 1e-9, "grid north is true north at the origin: {amersfoort}");
        // On the sphere onto which the ellipsoid is mapped, an oblique stereographic projection
        // has tan γ = sin Δλ (sin φ + sin φ₀) / (cos φ cos φ₀ + (1 + sin φ sin φ₀) cos Δλ). The
        // Gaussian sphere differs from the ellipsoid by 1e-3 relative at most.
        let at = DVec2::new(84_900.0, 447_500.0);
        let [latitude, longitude, _] = rd.to_wgs84(at.extend(0.0)).expect("Delft");
        let (phi, phi0) = (latitude.to_radians(), 52.156_160_56f64.to_radians());
        let delta = (longitude - 5.387_638_89).to_radians();
        let expected = (delta.sin() * (phi.sin() + phi0.sin()))
            .atan2(phi.cos() * phi0.cos() + (1.0 + phi.sin() * phi0.sin()) * delta.cos());
        let convergence = rd.meridian_convergence(at).expect("Delft");
        assert!((convergence / expected - 1.0).abs() < 2e-3, "{convergence} against {expected}");
    }

    #[test]
    fn positions_on_earth() {
        // Amersfoort, the origin of the Dutch grid, is at 52.15517° N, 5.38721° E in ETRS89.
        let [latitude, longitude, height] =
            crs("EPSG:28992").to_wgs84(DVec3::new(155_000.0, 463_000.0, 7.5)).expect("origin");
        // The seven parameters hold to a metre, 1e-5 degrees.
        assert!((latitude - 52.155_17).abs() < 1e-5 && (longitude - 5.387_21).abs() < 1.5e-5);
        assert_eq!(height, 7.5);
    }

    #[test]
    fn a_local_frame_agrees_with_the_ellipsoid() {
        let origin = [49.009_347_760_599, 8.437_134_430_837_5, 114.456];
        let local = Crs::parse("local", Some(origin)).expect("valid");
        assert_eq!(local.meridian_convergence(DVec2::new(50.0, 20.0)).expect("local"), 0.0);
        // The way back through ECEF is a forward formula: it must return to the point.
        for p in [DVec3::ZERO, DVec3::new(120.0, -45.0, 3.0), DVec3::new(-9e3, 2e4, 150.0)] {
            let [latitude, longitude, height] = local.to_wgs84(p).expect("has an origin");
            let found = wgs84::ecef(latitude.to_radians(), longitude.to_radians(), height);
            let (lat, lon) = (origin[0].to_radians(), origin[1].to_radians());
            let offset = found - wgs84::ecef(lat, lon, origin[2]);
            let east = DVec3::new(-lon.sin(), lon.cos(), 0.0);
            let up = DVec3::new(lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin());
            let back = DVec3::new(offset.dot(east), offset.dot(up.cross(east)), offset.dot(up));
            assert!(back.distance(p) < 1e-7, "{p} came back as {back}: degrees hold to 1e-9 m");
        }
        let nowhere = Crs::parse("local", None).expect("valid");
        assert_eq!(nowhere.to_wgs84(DVec3::ZERO), Err(CrsError::NoOrigin));
    }

    #[test]
    fn what_is_not_a_metric_grid_is_refused_with_a_remedy() {
        let refusal = |name: &str| Crs::parse(name, None).expect_err(name).to_string();
        insta::assert_snapshot!(refusal("EPSG:4326"), @"EPSG:4326 is not a projected CRS (its coordinates are degrees); convert the survey to a projected CRS in metres, such as the UTM zone around it");
        insta::assert_snapshot!(refusal("EPSG:4978"), @"EPSG:4978 is not a projected CRS (its coordinates are geocentric); convert the survey to a projected CRS in metres, such as the UTM zone around it");
        insta::assert_snapshot!(refusal("EPSG:2285"), @"EPSG:2285 has units of 0.3048006096012192 m; convert the survey to a CRS in metres with x east and y north");
        insta::assert_snapshot!(refusal("EPSG:2048"), @r#"EPSG:2048 has the axes "wsu"; convert the survey to a CRS in metres with x east and y north"#);
        insta::assert_snapshot!(refusal("EPSG:1"), @r#"EPSG:1 is not a known projected CRS; use the code of a projected CRS in metres, or "local""#);
        insta::assert_snapshot!(refusal("EPSG:900913"), @r#"EPSG:900913 is not a known projected CRS; use the code of a projected CRS in metres, or "local""#);
        insta::assert_snapshot!(refusal("Lambert 93"), @r#"CRS "Lambert 93" is not understood; write "EPSG:" and a code, or "local""#);
        assert!(Crs::parse("local", Some([91.0, 0.0, 0.0])).is_err());
        assert!(Crs::parse("local", Some([f64::NAN, 0.0, 0.0])).is_err());
        assert!(Crs::parse("EPSG:2154", Some([48.0, 2.0, 0.0])).is_err());
    }

    #[test]
    fn far_and_poisoned_points_are_errors_or_finite() {
        let lambert = crs("EPSG:2154");
        for at in [DVec2::NAN, DVec2::INFINITY, DVec2::splat(1e300), DVec2::splat(-1e9)] {
            if let Ok(angle) = lambert.meridian_convergence(at) {
                assert!(angle.is_finite(), "{at}");
            }
            if let Ok(place) = lambert.to_wgs84(at.extend(0.0)) {
                assert!(place.iter().all(|v| v.is_finite()), "{at}");
            }
        }
    }

    #[test]
    fn names_of_the_same_plan() {
        assert_eq!(epsg_code("urn:ogc:def:crs:EPSG::28992"), Some(28_992));
        assert_eq!(epsg_code("urn:ogc:def:crs:EPSG:6.9:2154"), Some(2154));
        assert_eq!(epsg_code("https://www.opengis.net/def/crs/EPSG/0/7415"), Some(7415));
        assert_eq!(epsg_code("EPSG:2154"), Some(2154));
        assert_eq!(epsg_code("urn:ogc:def:crs:OGC:1.3:CRS84"), None);
        assert_eq!(epsg_code("EPSG"), None);
        assert!(crs("EPSG:28992").has_plan_of(7415) && crs("EPSG:28992").has_plan_of(28_992));
        assert!(!crs("EPSG:28992").has_plan_of(2154) && !crs("local").has_plan_of(2154));
    }
}
