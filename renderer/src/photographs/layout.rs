//! Where photographs lie in their texture arrays, apart from the device: what is planned on a copy
//! comes out alike when it is done.

use glam::UVec2;

use super::packing::Packing;

/// Sides of the layers of each array, pixels.
pub(crate) const SIDES: [u32; 4] = [1024, 2048, 4096, 8192];
/// Levels of detail below the full one.
pub(crate) const MAX_LOD: u32 = 4;

/// Where a photograph lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    /// Index in [`SIDES`].
    pub(crate) array: usize,
    pub(crate) layer: u32,
    pub(crate) corner: UVec2,
    pub(crate) size: UVec2,
}

/// Why there is no place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NoPlace {
    /// The photograph is larger than the largest layer of the device.
    TooLarge { side: u32 },
    /// The textures would exceed what they may take.
    Memory,
    /// The device has no more layers or no more memory.
    Device,
}

/// What is taken of the layers of all arrays.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    /// In the order of [`SIDES`].
    arrays: [Vec<Packing>; SIDES.len()],
    /// Longest side of a layer that the device takes.
    max_side: u32,
    /// Most layers of an array.
    max_layers: usize,
}

impl Layout {
    /// No layers.
    pub(super) fn new(limits: &wgpu::Limits) -> Self {
        Self {
            arrays: Default::default(),
            max_side: limits.max_texture_dimension_2d.min(SIDES[SIDES.len() - 1]),
            max_layers: limits.max_texture_array_layers as usize,
        }
    }

    /// How many layers each array has.
    pub(super) fn layers(&self) -> [usize; SIDES.len()] {
        self.arrays.each_ref().map(Vec::len)
    }

    /// Finds room for a photograph, in more layers where all arrays together then take at most `most`
    /// bytes. Where that is tight, empty layers at the end of arrays are given up first.
    pub(super) fn take(&mut self, size: UVec2, most: u64) -> Result<Place, NoPlace> {
        let longest = taken(size).max_element();
        let class = SIDES
            .iter()
            .position(|&class| class <= self.max_side && longest <= class)
            .ok_or(NoPlace::TooLarge { side: self.max_side })?;
        if let Some(place) = self.take_of(class, size) {
            return Ok(place);
        }
        if self.held() + bytes(SIDES[class], 1) > most {
            self.trim();
        }
        // Half as much again, so that growing costs a bounded share of filling; a single
        // layer where there is no room for more.
        let layers = self.arrays[class].len();
        let generous = layers + (layers / 2).max(1);
        let others = self.held() - bytes(SIDES[class], layers);
        let fits = |to: usize| others + bytes(SIDES[class], to) <= most;
        let to = if fits(generous) { generous } else { layers + 1 };
        let may_grow = fits(to);
        let to = to.min(self.max_layers);
        if may_grow && to > layers {
            self.arrays[class].resize_with(to, || Packing::new(SIDES[class]));
            return self.take_of(class, size).ok_or(NoPlace::Device);
        }
        let none = if may_grow { NoPlace::Device } else { NoPlace::Memory };
        self.take_between(class, size).ok_or(none)
    }

    /// Finds room in between photographs too large for the array `class`.
    pub(super) fn take_between(&mut self, class: usize, size: UVec2) -> Option<Place> {
        (class + 1..self.arrays.len()).find_map(|class| self.take_of(class, size))
    }

    /// Frees what was taken.
    pub(super) fn remove(&mut self, place: &Place) {
        if let Some(packing) = self.arrays[place.array].get_mut(place.layer as usize) {
            packing.give_back(place.corner);
        }
    }

    /// Puts half the size of the photograph at `place` to where there is room for so little, so that
    /// what it leaves can serve one of its former size. `None` where there is none.
    pub(super) fn coarsen(&mut self, place: &Place, most: u64) -> Option<Place> {
        let size = level_size(place.size, 1);
        self.remove(place);
        self.take(size, most).ok().or_else(|| self.take_beside(place, size))
    }

    /// Finds room in the layer where `place` is.
    pub(super) fn take_beside(&mut self, place: &Place, size: UVec2) -> Option<Place> {
        let packing = self.arrays[place.array].get_mut(place.layer as usize)?;
        Some(Place { corner: packing.take(taken(size))?, size, ..*place })
    }

    /// Loses the layers of an array beyond the first `layers`, with what was taken of them.
    pub(super) fn truncate(&mut self, array: usize, layers: usize) {
        self.arrays[array].truncate(layers);
    }

    fn take_of(&mut self, array: usize, size: UVec2) -> Option<Place> {
        self.arrays[array].iter_mut().zip(0..).find_map(|(packing, layer)| {
            let corner = packing.take(taken(size))?;
            Some(Place { array, layer, corner, size })
        })
    }

    /// Gives up layers at the end of arrays where no photograph lies in them.
    fn trim(&mut self) {
        for layers in &mut self.arrays {
            let used = layers.iter().rposition(|layer| !layer.is_empty());
            layers.truncate(used.map_or(0, |last| last + 1));
        }
    }

    /// Bytes of all layers, rounded up.
    fn held(&self) -> u64 {
        self.arrays.iter().zip(SIDES).map(|(layers, side)| bytes(side, layers.len())).sum()
    }
}

/// The room that a photograph takes: corners of all levels stay whole texels.
fn taken(size: UVec2) -> UVec2 {
    size.map(|side| side.next_multiple_of(1 << MAX_LOD))
}

/// Size of a level, rounded up.
pub(super) fn level_size(size: UVec2, level: u32) -> UVec2 {
    size.map(|side| side.div_ceil(1 << level))
}

/// Bytes of `layers` layers with their levels, at most a third more than the full one.
fn bytes(side: u32, layers: usize) -> u64 {
    u64::from(side) * u64::from(side) * 4 * layers as u64 * 4 / 3
}
