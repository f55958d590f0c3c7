//! Room on the device for the scene and for pictures of it.

use glam::{DVec3, UVec2};

use super::Renderer;
use crate::align::AlignPass;
use crate::complete::CompletePass;
use crate::forward::ForwardPass;
use crate::frustum::Frustum;
use crate::gains::Gains;
use crate::infer::{Grid, InferPass};
use crate::targets::Targets;
use crate::{MemoryReport, RenderError};

/// What the memory of a picture depends on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Picture<'a> {
    pub(super) gbuffer: UVec2,
    pub(super) size: UVec2,
    /// The grids of inference, completion and alignment, where there are any.
    pub(super) inferring: Option<Grid>,
    pub(super) completing: Option<Grid>,
    pub(super) aligning: Option<Grid>,
    pub(super) frustum: &'a Frustum,
    pub(super) eye: DVec3,
}

impl Renderer {
    /// What it holds of the device's memory.
    pub fn memory(&self) -> MemoryReport {
        MemoryReport {
            points: self.points.bytes(),
            mesh: self.mesh.bytes(),
            photographs: self.photographs.atlas.bytes(),
            depth_maps: self.maps.bytes(),
            large_discs: self.splat_pass.bytes(),
            targets: self.targets.as_ref().map_or(0, Targets::bytes),
            inference: self.infer_pass.bytes()
                + self.histories.bytes()
                + self.complete_pass.bytes(),
            alignment: self.align_pass.bytes(),
            sprites: self.forward_pass.as_ref().map_or(0, ForwardPass::bytes),
            gains: self.gains.bytes(),
        }
    }

    /// Gives back what is made anew for the next picture, where the scene has taken its room.
    pub(super) fn yield_room(&mut self) {
        if self.memory().total() > self.settings.gpu_memory_bytes {
            self.targets = None;
            self.histories.clear();
            self.infer_pass.release_but(None);
            self.complete_pass.release_but(None);
            self.align_pass.release_but(&self.gpu, None);
            self.forward_pass.iter_mut().for_each(ForwardPass::release);
            self.gains.release_but(0);
        }
    }

    /// Sees to it that `picture` fits beside the scene: takes the depth maps that it needs, and
    /// gives back what other pictures needed. How many bytes are left for sprites of points.
    pub(super) fn make_room(&mut self, picture: &Picture<'_>) -> Result<u64, RenderError> {
        let (most, rigs) = (self.maps.max_maps(), self.settings.rigs);
        let used = self.photographs.select(picture.frustum, picture.eye, rigs, most).len();
        self.maps.reserve(&self.gpu, used);
        let measured = if self.settings.exposure_gains { used } else { 0 };

        self.targets.take_if(|targets| {
            (targets.gbuffer_size, targets.picture_size) != (picture.gbuffer, picture.size)
        });
        self.infer_pass.release_but(picture.inferring);
        self.complete_pass.release_but(picture.completing);
        self.align_pass.release_but(&self.gpu, picture.aligning);
        self.gains.release_but(measured);

        let needed = Targets::bytes_for(picture.gbuffer, picture.size)
            + picture.inferring.map_or(0, InferPass::bytes_for)
            + picture.completing.map_or(0, CompletePass::bytes_for)
            + picture.aligning.map_or(self.align_pass.bytes(), AlignPass::bytes_for)
            + Gains::bytes_for(measured);
        let (held, most) = (self.memory().of_scene(), self.settings.gpu_memory_bytes);
        if held + needed + self.histories.bytes() > most {
            self.histories.clear();
        }
        let left = most.checked_sub(held + needed + self.histories.bytes());
        let left = left.ok_or(RenderError::ViewMemory { needed, held, most })?;
        if let Some(pass) = self.forward_pass.as_mut().filter(|pass| pass.bytes() > left) {
            pass.release();
        }
        Ok(left)
    }
}
