//! What a pixel or a point shows.

/// The classes of the label images.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Class {
    /// Nothing but sky.
    Sky = 0,
    /// Roadway.
    Road = 1,
    /// Pavement for walking, and kerbs.
    Sidewalk = 2,
    /// Walls and what is fixed to them.
    Building = 3,
    /// Panes of windows, shop windows and glazed doors.
    Window = 4,
    /// Roofs and chimneys.
    Roof = 5,
    /// Trunks and leaves.
    Vegetation = 6,
    /// Lamp posts, signs, bollards, bins.
    Furniture = 7,
    /// Parked cars.
    Car = 8,
    /// The vehicle that carries the cameras.
    OwnVehicle = 9,
    /// Pixels that the lens does not reach.
    NoData = 255,
}

impl Class {
    /// Every class, in the order of the ids.
    pub const ALL: [Self; 11] = [
        Self::Sky,
        Self::Road,
        Self::Sidewalk,
        Self::Building,
        Self::Window,
        Self::Roof,
        Self::Vegetation,
        Self::Furniture,
        Self::Car,
        Self::OwnVehicle,
        Self::NoData,
    ];

    /// The id in label images.
    pub fn id(self) -> u8 {
        self as u8
    }

    /// The class with this id.
    pub fn from_id(id: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|class| class.id() == id)
    }

    /// Its name in `labels/classes.json`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sky => "sky",
            Self::Road => "road",
            Self::Sidewalk => "sidewalk",
            Self::Building => "building",
            Self::Window => "window",
            Self::Roof => "roof",
            Self::Vegetation => "vegetation",
            Self::Furniture => "furniture",
            Self::Car => "car",
            Self::OwnVehicle => "own-vehicle",
            Self::NoData => "no-data",
        }
    }

    /// The LAS class that the lidar gives its points: 2 ground, 5 high vegetation, 6
    /// building, and two user-defined ones; `None` for what lidar does not return.
    pub fn las(self) -> Option<u8> {
        match self {
            Self::Road | Self::Sidewalk => Some(2),
            Self::Vegetation => Some(5),
            Self::Building | Self::Window | Self::Roof => Some(6),
            Self::Car => Some(64),
            Self::Furniture => Some(65),
            Self::Sky | Self::OwnVehicle | Self::NoData => None,
        }
    }
}
