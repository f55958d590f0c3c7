//! How far the work has come.

/// What is being made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stage {
    /// Houses, trees, cars, and the light between them; one step each.
    Street,
    /// Photographs, label images included.
    Photographs,
    /// Held-out views.
    Views,
    /// Lidar points.
    Points,
}

impl Stage {
    /// What is counted.
    pub fn name(self) -> &'static str {
        match self {
            Self::Street => "street",
            Self::Photographs => "photographs",
            Self::Views => "held-out views",
            Self::Points => "lidar points",
        }
    }
}

/// A step of a stage. Steps of a stage may be reported out of order by a few.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// What is being made.
    pub stage: Stage,
    /// How much of it there is.
    pub done: u64,
    /// How much there will be; for points, about.
    pub total: u64,
}

/// What a sample holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Summary {
    /// Buildings in the footprints.
    pub buildings: u64,
    /// Photographs of the rig and spheres.
    pub photographs: u64,
    /// Held-out views.
    pub views: u64,
    /// Lidar points.
    pub points: u64,
    /// LAZ files that hold them.
    pub point_files: u64,
}
