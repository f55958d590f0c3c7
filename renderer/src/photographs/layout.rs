//! Where photographs lie in their texture arrays, apart from the device: what is planned on a copy
//! comes out alike when it is done.

use glam::UVec2;

use super::packing::Packing;

/// Widths of the layers of each array, pixels; each is half as high again, for the levels, as far as
/// the device has such textures.
pub(super) const SIDES: [u32; 4] = [1024, 2048, 4096, 8192];
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
    /// Of the layers of its array.
    pub(crate) layer_size: UVec2,
}

impl Place {
    /// Where a level of the photograph begins: the full one first, below it all others side by side.
    /// texel.wgsl has the same.
    pub(crate) fn level_corner(&self, level: u32) -> UVec2 {
        let full = whole_levels(self.size);
        if level == 0 {
            return self.corner;
        }
        self.corner + UVec2::new(full.x - ((2 * full.x) >> level), full.y)
    }

    /// The finest level below which no texel is halved, at most [`MAX_LOD`].
    pub(crate) fn coarsest(&self) -> u32 {
        self.size.min_element().ilog2().min(MAX_LOD)
    }
}

/// The full level as far as all levels are whole texels of it.
fn whole_levels(size: UVec2) -> UVec2 {
    size.map(|side| side.next_multiple_of(1 << MAX_LOD))
}

/// Why there is no place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NoPlace {
    /// The photograph is larger than the largest layer of the device, of this width.
    TooLarge { side: u32 },
    /// The textures would exceed what they may take, or what the device gives.
    Memory,
}

/// What is taken of the layers of all arrays.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    /// In the order of [`SIDES`].
    arrays: [Vec<Packing>; SIDES.len()],
    /// Longest side of a texture that the device takes.
    max_side: u32,
    /// Most layers of each array.
    max_layers: [usize; SIDES.len()],
}

impl Layout {
    /// No layers.
    pub(super) fn new(limits: &wgpu::Limits) -> Self {
        let max_layers = limits.max_texture_array_layers as usize;
        Self {
            arrays: Default::default(),
            max_side: limits.max_texture_dimension_2d,
            max_layers: [max_layers; SIDES.len()],
        }
    }

    /// How many layers each array has.
    pub(super) fn layers(&self) -> [usize; SIDES.len()] {
        self.arrays.each_ref().map(Vec::len)
    }

    /// Finds room for a photograph, in more layers where all arrays together then take at most `most`
    /// bytes. Where that is tight, empty layers at the end of arrays are given up first.
    pub(super) fn take(&mut self, size: UVec2, most: u64) -> Result<Place, NoPlace> {
        let class = SIDES
            .iter()
            .position(|&side| taken(size).cmple(layer_size(side, self.max_side)).all())
            .ok_or(NoPlace::TooLarge { side: self.max_side.min(SIDES[SIDES.len() - 1]) })?;
        if let Some(place) = self.take_of(class, size) {
            return Ok(place);
        }
        if self.held() + self.bytes(class, 1) > most {
            self.trim();
        }
        // An array that has all layers that it can have leaves it to the next.
        let growing =
            (class..SIDES.len()).find(|&array| self.layers()[array] < self.max_layers[array]);
        if growing == Some(class) && self.grow(class, most) {
            return self.take_of(class, size).ok_or(NoPlace::Memory);
        }
        if let Some(place) = self.take_between(class, size) {
            return Ok(place);
        }
        let array = growing.filter(|&array| array > class && self.grow(array, most));
        array.and_then(|array| self.take_of(array, size)).ok_or(NoPlace::Memory)
    }

    /// Takes note that the device has no room for so many layers of an array: it keeps the first `held`,
    /// and will not have as many again.
    pub(super) fn refused(&mut self, array: usize, layers: usize, held: usize) {
        self.arrays[array].truncate(held);
        self.max_layers[array] = held.max(layers.saturating_sub(1));
    }

    /// Whether an array has got more layers, all arrays together taking at most `most` bytes: half as much
    /// again, so that growing costs a bounded share of filling; a single one where there is no
    /// room for more.
    fn grow(&mut self, array: usize, most: u64) -> bool {
        let layers = self.arrays[array].len();
        let generous = layers + (layers / 2).max(1);
        let others = self.held() - self.bytes(array, layers);
        let fits = |to: usize| others + self.bytes(array, to) <= most;
        let to = if fits(generous) { generous } else { layers + 1 };
        let may_grow = fits(to) && layers < self.max_layers[array];
        if may_grow {
            let (to, layer) = (to.min(self.max_layers[array]), self.layer_size(array));
            self.arrays[array].resize_with(to, || Packing::new(layer));
        }
        may_grow
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

    fn take_of(&mut self, array: usize, size: UVec2) -> Option<Place> {
        let layer_size = self.layer_size(array);
        self.arrays[array].iter_mut().zip(0..).find_map(|(packing, layer)| {
            let corner = packing.take(taken(size))?;
            Some(Place { array, layer, corner, size, layer_size })
        })
    }

    /// Gives up layers at the end of arrays where no photograph lies in them.
    fn trim(&mut self) {
        for layers in &mut self.arrays {
            let used = layers.iter().rposition(|layer| !layer.is_empty());
            layers.truncate(used.map_or(0, |last| last + 1));
        }
    }

    /// Size of the layers of an array.
    pub(super) fn layer_size(&self, array: usize) -> UVec2 {
        layer_size(SIDES[array], self.max_side)
    }

    /// Bytes of all layers.
    fn held(&self) -> u64 {
        self.arrays.iter().enumerate().map(|(array, layers)| self.bytes(array, layers.len())).sum()
    }

    /// Bytes of so many layers of an array.
    fn bytes(&self, array: usize, layers: usize) -> u64 {
        let UVec2 { x, y } = self.layer_size(array);
        u64::from(x) * u64::from(y) * 4 * layers as u64
    }
}

/// The room that a photograph takes: the full level, and below it, half as high, all others.
fn taken(size: UVec2) -> UVec2 {
    let full = whole_levels(size);
    UVec2::new(full.x, full.y + full.y / 2)
}

/// Size of a level, rounded up.
pub(super) fn level_size(size: UVec2, level: u32) -> UVec2 {
    size.map(|side| side.div_ceil(1 << level))
}

/// Size of a layer of an array on a device with textures of at most `max_side`.
fn layer_size(side: u32, max_side: u32) -> UVec2 {
    UVec2::new(side, side + side / 2).min(UVec2::splat(max_side))
}
