//! The command buffers of a frame: one for all passes, or one each where they are timed.

use std::time::{Duration, Instant};

use crate::{Gpu, RenderError};

/// How long a pass took.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PassTime {
    /// Name of the pass.
    pub pass: &'static str,
    /// From the end of the pass before it to its own, on the wall's clock: what the host does
    /// for it, and the device.
    pub time: Duration,
}

/// Records commands, and where asked for waits after every pass.
#[derive(Debug)]
pub(crate) struct Stages {
    gpu: Gpu,
    encoder: Option<wgpu::CommandEncoder>,
    timed: Option<(Instant, Vec<PassTime>)>,
}

impl Stages {
    pub(crate) fn untimed(gpu: &Gpu) -> Self {
        Self { gpu: gpu.clone(), encoder: None, timed: None }
    }

    pub(crate) fn timed(gpu: &Gpu) -> Self {
        Self { gpu: gpu.clone(), encoder: None, timed: Some((Instant::now(), Vec::new())) }
    }

    /// Where the next commands go.
    pub(crate) fn encoder(&mut self) -> &mut wgpu::CommandEncoder {
        self.encoder
            .get_or_insert_with(|| self.gpu.device.create_command_encoder(&Default::default()))
    }

    /// Says that the commands of a pass are complete.
    pub(crate) fn ended(&mut self, pass: &'static str) -> Result<(), RenderError> {
        if self.timed.is_some() {
            self.submit();
            self.gpu
                .device
                .poll(wgpu::PollType::wait_indefinitely())
                .map_err(|error| RenderError::Driver(error.to_string()))?;
        }
        if let Some((since, times)) = &mut self.timed {
            times.push(PassTime { pass, time: since.elapsed() });
            *since = Instant::now();
        }
        Ok(())
    }

    /// Hands what was recorded to the device.
    pub(crate) fn submit(&mut self) {
        if let Some(encoder) = self.encoder.take() {
            self.gpu.queue.submit([encoder.finish()]);
        }
    }

    /// The times, in the order of the passes.
    pub(crate) fn times(self) -> Vec<PassTime> {
        self.timed.map(|(_, times)| times).unwrap_or_default()
    }
}
