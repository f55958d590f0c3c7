//! From the text of a `street.toml` to a [`Street`].

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use toml::de::{DeTable, DeValue};

use super::super::{BadInput, IngestError};
use super::section::{Document, Entry, Section, check_keys};
use super::{
    ColmapSpec, EquirectangularSpec, FootprintsFormat, FootprintsSpec, GroundSpec, HeightSource,
    ImagePattern, ItownsSpec, MaskColour, North, PanoramasSpec, PointsSpec, Root, SceneSpec,
    Street, glob,
};

/// Most bytes a `street.toml` may have.
const MAX_BYTES: u64 = 1 << 20;

/// Most bytes the name of a scene or a point source may have.
const MAX_NAME: usize = 64;

const SECTIONS: [&str; 5] = ["scene", "ground", "footprints", "panoramas", "points"];

impl Street {
    /// Reads the `street.toml` at `path`, or the one in the folder `path`.
    ///
    /// Every file it names exists afterwards, except photographs, which are looked for when
    /// they are read. `confine`: see [`Root::resolve`].
    pub fn open(path: &Path, confine: bool) -> Result<Self, IngestError> {
        let file = if path.is_dir() { path.join("street.toml") } else { path.to_owned() };
        let unreadable = |error: &std::io::Error| {
            let remedy = "give a folder that holds a street.toml, or that file";
            BadInput::error(&file, "", format!("cannot read it: {error}"), remedy)
        };
        let size = std::fs::metadata(&file).map_err(|error| unreadable(&error))?.len();
        if size > MAX_BYTES {
            return Err(BadInput::error(
                &file,
                "",
                format!("it has {size} bytes, more than {MAX_BYTES}"),
                "give a street.toml, not the data itself",
            ));
        }
        let file = file.canonicalize().map_err(|error| unreadable(&error))?;
        let text = std::fs::read_to_string(&file).map_err(|error| unreadable(&error))?;
        let folder = file.parent().unwrap_or(Path::new("/"));
        let root = Root::new(folder, confine).map_err(|error| unreadable(&error))?;
        parse(&file, &text, root)
    }

    /// Whether `name` may name a scene or a point source: 1 to 64 ASCII letters, digits, `-`,
    /// `_` and `.`, the first no `.`.
    pub fn is_name(name: &str) -> bool {
        let fits = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
        (1..=MAX_NAME).contains(&name.len()) && !name.starts_with('.') && name.chars().all(fits)
    }
}

/// Reads `text`, the contents of `file`.
fn parse(file: &Path, text: &str, root: Root) -> Result<Street, IngestError> {
    let document = Document { file, text };
    let table = DeTable::parse(text).map_err(|error| {
        let offset = error.span().map_or(0, |span| span.start);
        let message = error.message().split_whitespace().collect::<Vec<_>>().join(" ");
        document.fault(offset, format!("this is no TOML: {message}"), "correct the line")
    })?;
    let table = table.get_ref();
    check_keys(&document, "the file", table, &SECTIONS)?;

    let scene = one(&document, table, "scene", "[scene]")?;
    let scene = scene.ok_or_else(|| {
        document.fault(
            0,
            "there is no [scene]",
            "add [scene] with name = \"...\" and crs = \"...\"",
        )
    })?;
    let scene = scene_spec(&scene)?;
    let points = points_specs(&many(&document, table, "points", "[[points]]")?, &root)?;
    let ground = one(&document, table, "ground", "[ground]")?;
    let ground = ground.map(|section| ground_spec(&section, &root, &points)).transpose()?;
    let footprints = many(&document, table, "footprints", "[[footprints]]")?
        .iter()
        .map(|section| footprints_spec(section, &root, &points))
        .collect::<Result<Vec<_>, _>>()?;
    let panoramas = many(&document, table, "panoramas", "[[panoramas]]")?
        .iter()
        .map(|section| panoramas_spec(section, &root))
        .collect::<Result<Vec<_>, _>>()?;
    if footprints.is_empty() && panoramas.is_empty() && points.is_empty() {
        return Err(document.fault(
            0,
            "the street is empty",
            "add [[points]], [[footprints]] or [[panoramas]]",
        ));
    }
    Ok(Street { file: file.to_owned(), root, scene, ground, footprints, panoramas, points })
}

/// The section of a name that may occur once.
fn one<'a>(
    document: &'a Document<'a>,
    table: &'a DeTable<'a>,
    key: &str,
    name: &'a str,
) -> Result<Option<Section<'a>>, IngestError> {
    let Some((found, value)) = table.get_key_value(key) else { return Ok(None) };
    let start = found.span().start;
    match value.get_ref() {
        DeValue::Table(table) => Ok(Some(Section { document, name, start, table })),
        _ => Err(document.fault(
            start,
            format!("`{key}` is not a table"),
            format!("write it once, as {name}"),
        )),
    }
}

/// The sections of a name that may occur several times.
fn many<'a>(
    document: &'a Document<'a>,
    table: &'a DeTable<'a>,
    key: &str,
    name: &'a str,
) -> Result<Vec<Section<'a>>, IngestError> {
    let Some((found, value)) = table.get_key_value(key) else { return Ok(Vec::new()) };
    let fault = |start: usize| {
        let problem = format!("`{key}` is not a list of tables");
        document.fault(start, problem, format!("write {name}, in double brackets, for each"))
    };
    let items = value.get_ref().as_array().ok_or_else(|| fault(found.span().start))?;
    items
        .iter()
        .map(|item| match item.get_ref() {
            DeValue::Table(table) => {
                Ok(Section { document, name, start: item.span().start, table })
            }
            _ => Err(fault(item.span().start)),
        })
        .collect()
}

fn scene_spec(section: &Section<'_>) -> Result<SceneSpec, IngestError> {
    section.only(&["name", "crs", "geographic_origin"])?;
    let name = name(&section.require("name", "\"my-street\"")?)?;
    let crs_entry = section.require("crs", "\"EPSG:2154\", or \"local\"")?;
    let crs = crs_entry.text()?;
    let is_epsg = crs.strip_prefix("EPSG:").is_some_and(|code| code.parse::<u32>().is_ok());
    if crs != "local" && !is_epsg {
        return Err(crs_entry.fault(
            "this is no known way to name a CRS",
            "write crs = \"EPSG:2154\" with the code of a projected CRS, or crs = \"local\"",
        ));
    }
    let geographic_origin = match section.get("geographic_origin") {
        None => None,
        Some(entry) if is_epsg => {
            return Err(entry.fault("the CRS already says where the street is", "remove it"));
        }
        Some(entry) => {
            let [latitude, longitude, height] = entry.three_numbers()?;
            if latitude.abs() > 90.0 || longitude.abs() > 180.0 {
                return Err(entry.fault(
                    "there is no such place",
                    "write [latitude, longitude, height], in degrees and metres",
                ));
            }
            Some([latitude, longitude, height])
        }
    };
    Ok(SceneSpec { name, crs: crs.to_owned(), geographic_origin })
}

fn points_specs(sections: &[Section<'_>], root: &Root) -> Result<Vec<PointsSpec>, IngestError> {
    let mut taken: BTreeSet<String> = BTreeSet::new();
    // Names that were given come first, so that none that is made up takes one of them.
    for section in sections {
        section.only(&["path", "name"])?;
        if let Some(entry) = section.get("name")
            && !taken.insert(name(&entry)?)
        {
            return Err(entry.fault("another [[points]] has that name", "choose another"));
        }
    }
    sections
        .iter()
        .map(|section| {
            let entry = section.require("path", "\"tiles/*.laz\"")?;
            let files = files(&entry, root)?;
            let name = match section.get("name") {
                Some(entry) => name(&entry)?,
                None => free_name(entry.text()?, &mut taken),
            };
            Ok(PointsSpec { name, files })
        })
        .collect()
}

/// A name made from a pattern (`tiles/ahn3_*.laz` gives `ahn3`) that is not taken.
fn free_name(pattern: &str, taken: &mut BTreeSet<String>) -> String {
    let file = pattern.rsplit('/').next().unwrap_or_default();
    let stem = file.split('.').next().unwrap_or_default();
    let fits = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
    let stem: String = stem.chars().filter(|&c| fits(c)).take(MAX_NAME / 2).collect();
    let stem = stem.trim_matches(['-', '_']);
    let stem = if stem.is_empty() { "points" } else { stem };
    let mut name = stem.to_owned();
    let mut number = 2;
    while !taken.insert(name.clone()) {
        name = format!("{stem}-{number}");
        number += 1;
    }
    name
}

fn ground_spec(
    section: &Section<'_>,
    root: &Root,
    points: &[PointsSpec],
) -> Result<GroundSpec, IngestError> {
    section.only(&["format", "height_m", "path", "classes"])?;
    let format = section.require("format", "\"points\", \"points-json\" or \"constant\"")?;
    match format.choice(&[("constant", 0), ("points-json", 1), ("points", 2)])? {
        0 => {
            section.only(&["format", "height_m"])?;
            Ok(GroundSpec::Constant { height_m: section.require("height_m", "0.0")?.number()? })
        }
        1 => {
            section.only(&["format", "path"])?;
            Ok(GroundSpec::PointsJson {
                path: file(&section.require("path", "\"dtm.json\"")?, root)?,
            })
        }
        _ => {
            section.only(&["format", "classes"])?;
            if points.is_empty() {
                return Err(format.fault(
                    "there are no [[points]]",
                    "add [[points]], or give the ground as \"constant\" or \"points-json\"",
                ));
            }
            let classes = section.get("classes").map(|entry| entry.classes()).transpose()?;
            Ok(GroundSpec::Points { classes })
        }
    }
}

fn footprints_spec(
    section: &Section<'_>,
    root: &Root,
    points: &[PointsSpec],
) -> Result<FootprintsSpec, IngestError> {
    section.only(&["path", "format", "height_property", "height", "uncertainty_m"])?;
    let path = file(&section.require("path", "\"buildings.geojson\"")?, root)?;
    let format = section.get("format").map(|entry| {
        entry.choice(&[
            ("geojson", FootprintsFormat::GeoJson),
            ("flatgeobuf", FootprintsFormat::FlatGeobuf),
            ("cityjson", FootprintsFormat::CityJson),
        ])
    });
    let height = match (section.get("height_property"), section.get("height")) {
        (Some(_), Some(height)) => {
            return Err(height.fault("`height_property` is given too", "keep one of the two"));
        }
        (Some(property), None) => Some(HeightSource::Property(property.text()?.to_owned())),
        (None, Some(height)) => Some(footprint_height(&height, points)?),
        (None, None) => None,
    };
    let uncertainty_m = section.uncertainty()?;
    Ok(FootprintsSpec { path, format: format.transpose()?, height, uncertainty_m })
}

fn footprint_height(entry: &Entry<'_>, points: &[PointsSpec]) -> Result<HeightSource, IngestError> {
    if entry.is_text() {
        entry.choice(&[("points", ())])?;
        if points.is_empty() {
            return Err(entry.fault(
                "there are no [[points]]",
                "add [[points]], or name an attribute with height_property = \"...\"",
            ));
        }
        return Ok(HeightSource::Points);
    }
    let height = entry.number()?;
    if !(height > 0.0) {
        return Err(entry.fault("expected more than zero", "give it in metres, or \"points\""));
    }
    Ok(HeightSource::Constant(height))
}

fn panoramas_spec(section: &Section<'_>, root: &Root) -> Result<PanoramasSpec, IngestError> {
    const POSE: [&str; 4] = ["heading", "height_offset_m", "boresight_deg", "uncertainty_m"];
    const ITOWNS: [&str; 6] =
        ["format", "poses", "calibration", "images", "masks_exclude", "refine_poses"];
    const COLMAP: [&str; 5] = ["format", "model", "images", "uncertainty_m", "refine_poses"];
    const EQUIRECTANGULAR: [&str; 3] = ["format", "list", "images"];
    section.only(&[&POSE[..], &ITOWNS, &["model", "list"]].concat())?;
    let format = section.require("format", "\"itowns\", \"colmap\" or \"equirectangular\"")?;
    let folder = |entry: &Entry<'_>| folder(entry, root);
    match format.choice(&[("itowns", 0), ("colmap", 1), ("equirectangular", 2)])? {
        0 => {
            section.only(&[&ITOWNS[..], &POSE].concat())?;
            let images = section.require("images", "\"images/{camera}_{panorama:07}.jpg\"")?;
            let pattern = ImagePattern::parse(images.text()?).map_err(|problem| {
                images.fault(&problem, "write for instance images/{camera}_{panorama:07}.jpg")
            })?;
            // Whether the names that fill it in lead elsewhere is seen when they are known.
            root.resolve(root.folder(), images.text()?, section.document.file, &images.place())?;
            let colours = [("white", MaskColour::White), ("black", MaskColour::Black)];
            Ok(PanoramasSpec::Itowns(ItownsSpec {
                root: root.clone(),
                poses: file(&section.require("poses", "\"poses.json\"")?, root)?,
                calibration: file(&section.require("calibration", "\"calibration.json\"")?, root)?,
                images: pattern,
                masks_exclude: section
                    .get("masks_exclude")
                    .map(|entry| entry.choice(&colours))
                    .transpose()?,
                heading: north(section)?,
                height_offset_m: height_offset(section)?,
                boresight_deg: boresight(section)?,
                uncertainty_m: section.uncertainty()?,
                refine_poses: refine_poses(section)?,
            }))
        }
        1 => {
            section.only(&COLMAP)?;
            Ok(PanoramasSpec::Colmap(ColmapSpec {
                root: root.clone(),
                model: folder(&section.require("model", "\"colmap/sparse/0\"")?)?,
                images: folder(&section.require("images", "\"images\"")?)?,
                uncertainty_m: section.uncertainty()?,
                refine_poses: refine_poses(section)?,
            }))
        }
        _ => {
            section.only(&[&EQUIRECTANGULAR[..], &POSE].concat())?;
            let list = file(&section.require("list", "\"panoramas.csv\"")?, root)?;
            let beside = list.parent().unwrap_or(root.folder()).to_owned();
            Ok(PanoramasSpec::Equirectangular(EquirectangularSpec {
                root: root.clone(),
                images: section.get("images").map(|entry| folder(&entry)).unwrap_or(Ok(beside))?,
                list,
                heading: north(section)?,
                height_offset_m: height_offset(section)?,
                boresight_deg: boresight(section)?,
                uncertainty_m: section.uncertainty()?,
            }))
        }
    }
}

fn north(section: &Section<'_>) -> Result<North, IngestError> {
    section.get("heading").map_or(Ok(North::Grid), |entry| {
        entry.choice(&[("grid-north", North::Grid), ("true-north", North::True)])
    })
}

/// By itself, unless it is forbidden.
fn refine_poses(section: &Section<'_>) -> Result<bool, IngestError> {
    section.get("refine_poses").map_or(Ok(true), |entry| entry.truth())
}

fn height_offset(section: &Section<'_>) -> Result<f64, IngestError> {
    section.get("height_offset_m").map_or(Ok(0.0), |entry| entry.number())
}

fn boresight(section: &Section<'_>) -> Result<[f64; 3], IngestError> {
    section.get("boresight_deg").map_or(Ok([0.0; 3]), |entry| entry.three_numbers())
}

fn name(entry: &Entry<'_>) -> Result<String, IngestError> {
    let name = entry.text()?;
    if !Street::is_name(name) {
        return Err(entry.fault(
            "this cannot be a name",
            format!("use 1 to {MAX_NAME} letters a-z A-Z, digits, '-', '_' and '.'"),
        ));
    }
    Ok(name.to_owned())
}

fn resolve(entry: &Entry<'_>, root: &Root) -> Result<PathBuf, IngestError> {
    root.resolve(root.folder(), entry.text()?, entry.document().file, &entry.place())
}

/// A file that exists.
fn file(entry: &Entry<'_>, root: &Root) -> Result<PathBuf, IngestError> {
    let path = resolve(entry, root)?;
    if path.is_file() {
        Ok(path)
    } else {
        Err(entry.fault("there is no such file", format!("no file {}", path.display())))
    }
}

/// A folder that exists.
fn folder(entry: &Entry<'_>, root: &Root) -> Result<PathBuf, IngestError> {
    let path = resolve(entry, root)?;
    if path.is_dir() {
        Ok(path)
    } else {
        Err(entry.fault("there is no such folder", format!("no folder {}", path.display())))
    }
}

/// The files that a pattern names: at least one.
fn files(entry: &Entry<'_>, root: &Root) -> Result<Vec<PathBuf>, IngestError> {
    let pattern = entry.text()?;
    resolve(entry, root)?;
    let files = glob::expand(root.folder(), pattern)
        .map_err(|error| entry.fault(&error.to_string(), "correct the pattern"))?;
    if files.is_empty() {
        return Err(
            entry.fault("no file matches", format!("paths start at {}", root.folder().display()))
        );
    }
    for file in &files {
        // A pattern can lead out through a symbolic link that it matches.
        let text = file.to_string_lossy();
        root.resolve(root.folder(), &text, entry.document().file, &entry.place())?;
    }
    Ok(files)
}
