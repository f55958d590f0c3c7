//! A rendered picture, and what went into it.

use glam::UVec2;

/// A finished picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Size in pixels.
    pub size: UVec2,
    /// sRGB, rows from the top, alpha 255 everywhere.
    pub rgba: Vec<u8>,
    /// What each pixel shows, in the order of `rgba`.
    pub surfaces: Vec<Surface>,
    /// Counts.
    pub stats: FrameStats,
}

/// What a pixel shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Surface {
    /// No geometry, and nothing inferred: the background colour.
    Background = 0,
    /// Mesh that no photograph reaches, in a neutral shade.
    MeshUncoloured = 1,
    /// Mesh coloured by at least one photograph.
    MeshColoured = 2,
    /// A point that no photograph reaches, in its own colour or a neutral shade.
    PointUncoloured = 3,
    /// A point coloured by at least one photograph.
    PointColoured = 4,
    /// No geometry, and no photograph reaches it: the colours of what is inferred around.
    Completed = 5,
    /// No geometry: what the photographs show at a depth on which they agree. Nothing may be
    /// measured there.
    Inferred = 6,
}

/// How much was there, and how much of it was used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameStats {
    /// Triangles resident.
    pub triangles: u64,
    /// Triangles refused since the renderer was made: with a corner that is not finite.
    pub triangles_refused: u64,
    /// Triangles of the tiles that meet the view.
    pub triangles_drawn: u64,
    /// Points resident.
    pub points: u64,
    /// Points of the chunks that meet the view.
    pub points_drawn: u64,
    /// Points refused since the renderer was made: not finite, or too far from their origin.
    pub points_refused: u64,
    /// Photographs resident.
    pub images: u64,
    /// Photographs of the nearest rigs that can see something of the view.
    pub images_drawn: u64,
    /// Pixels of the picture.
    pub pixels: u64,
    /// Pixels that show mesh or points.
    pub geometry_pixels: u64,
    /// Pixels that show mesh or points and that at least one photograph colours.
    pub coloured_pixels: u64,
    /// Pixels without geometry that photographs colour at an inferred depth.
    pub inferred_pixels: u64,
    /// Pixels without geometry that no photograph reaches and that take the colours around.
    pub completed_pixels: u64,
}

impl Surface {
    /// Whether the pixel shows mesh or a point.
    pub fn is_geometry(self) -> bool {
        !matches!(self, Self::Background | Self::Completed | Self::Inferred)
    }

    /// Whether the pixel shows mesh or a point and a photograph colours it.
    pub fn is_coloured(self) -> bool {
        matches!(self, Self::MeshColoured | Self::PointColoured)
    }

    /// In the order of their codes.
    const ALL: [Self; 7] = [
        Self::Background,
        Self::MeshUncoloured,
        Self::MeshColoured,
        Self::PointUncoloured,
        Self::PointColoured,
        Self::Completed,
        Self::Inferred,
    ];

    fn from_code(code: u8) -> Self {
        Self::ALL.get(usize::from(code)).copied().unwrap_or(Self::Background)
    }
}

impl FrameStats {
    /// The share of the pixels showing geometry that at least one photograph colours, 0 to 1;
    /// 0 where no pixel shows geometry.
    pub fn coverage(&self) -> f64 {
        if self.geometry_pixels == 0 {
            return 0.0;
        }
        self.coloured_pixels as f64 / self.geometry_pixels as f64
    }

    /// The share of all pixels that photographs colour at an inferred depth, 0 to 1.
    pub fn inferred_share(&self) -> f64 {
        self.inferred_pixels as f64 / self.pixels.max(1) as f64
    }

    /// The same with the counts of pixels of what a picture shows.
    pub(crate) fn counting(self, surfaces: &[Surface]) -> Self {
        let mut counted = Self {
            pixels: surfaces.len() as u64,
            geometry_pixels: 0,
            coloured_pixels: 0,
            inferred_pixels: 0,
            completed_pixels: 0,
            ..self
        };
        for &surface in surfaces {
            counted.geometry_pixels += u64::from(surface.is_geometry());
            counted.coloured_pixels += u64::from(surface.is_coloured());
            counted.inferred_pixels += u64::from(surface == Surface::Inferred);
            counted.completed_pixels += u64::from(surface == Surface::Completed);
        }
        counted
    }
}

impl Frame {
    /// The picture whose alpha holds [`Surface`] codes, as the shading pass leaves it.
    pub(crate) fn from_coded(size: UVec2, mut rgba: Vec<u8>, stats: FrameStats) -> Self {
        let (pixels, _) = rgba.as_chunks_mut::<4>();
        let surfaces: Vec<Surface> = pixels
            .iter_mut()
            .map(|[.., alpha]| Surface::from_code(std::mem::replace(alpha, 255)))
            .collect();
        let stats = stats.counting(&surfaces);
        Self { size, rgba, surfaces, stats }
    }
}
