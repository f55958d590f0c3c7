//! The device that renderers share.

use crate::RenderError;

/// What is used where a device has it.
const WELCOME: wgpu::Features =
    wgpu::Features::FLOAT32_BLENDABLE.union(wgpu::Features::POLYGON_MODE_LINE).union(ATOMIC_64);
/// What atomics of 64 bits need.
const ATOMIC_64: wgpu::Features =
    wgpu::Features::SHADER_INT64.union(wgpu::Features::SHADER_INT64_ATOMIC_MIN_MAX);

/// A graphics device without a window. Clones share the device.
#[derive(Clone, Debug)]
pub struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    info: wgpu::AdapterInfo,
}

impl Gpu {
    /// Opens the best adapter: discrete before integrated before virtual before software.
    ///
    /// # Errors
    /// [`RenderError::NoAdapter`] where there is none, [`RenderError::Device`] where the
    /// driver refuses to open it.
    pub fn new() -> Result<Self, RenderError> {
        pollster::block_on(Self::open())
    }

    /// Name of the adapter, as its driver gives it.
    pub fn adapter_name(&self) -> &str {
        &self.info.name
    }

    /// Whether the adapter is a program on the processor.
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }

    /// Whether shaders may take the least of words of 64 bits, see
    /// [`SplatRoute`](crate::SplatRoute).
    pub fn has_64_bit_atomics(&self) -> bool {
        self.device.features().contains(ATOMIC_64)
    }

    /// Does something with the device. What the driver refuses meanwhile is an error; without this it
    /// would be the end of the process.
    pub(crate) fn watched<T>(
        &self,
        work: impl FnOnce() -> Result<T, RenderError>,
    ) -> Result<T, RenderError> {
        use wgpu::ErrorFilter::{Internal, OutOfMemory, Validation};
        let scopes =
            [Validation, Internal, OutOfMemory].map(|kind| self.device.push_error_scope(kind));
        let outcome = work();
        // Begun last, ended first. What could not be allocated is no good to use: that is the cause.
        let faults = scopes.into_iter().rev().map(|scope| pollster::block_on(scope.pop()));
        let faults: Vec<wgpu::Error> = faults.flatten().collect();
        match faults.first() {
            None => outcome,
            Some(wgpu::Error::OutOfMemory { .. }) => Err(RenderError::DeviceMemory),
            Some(fault) => Err(RenderError::Driver(fault.to_string())),
        }
    }

    async fn open() -> Result<Self, RenderError> {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        // The arguments of indirect draws are this crate's own.
        descriptor.flags.remove(wgpu::InstanceFlags::VALIDATION_INDIRECT_CALL);
        let instance = wgpu::Instance::new(descriptor);
        let mut adapters = instance.enumerate_adapters(wgpu::Backends::PRIMARY).await;
        // Stable: among equals the driver's own order decides.
        adapters.sort_by_key(|adapter| preference(adapter.get_info().device_type));
        let adapter = adapters.into_iter().next().ok_or(RenderError::NoAdapter)?;
        let info = adapter.get_info();
        let (device, queue) = adapter
            .request_device(&wgpu::DeviceDescriptor {
                label: Some("flaneur"),
                required_features: adapter.features() & WELCOME,
                required_limits: adapter.limits(),
                ..Default::default()
            })
            .await
            .map_err(|error| RenderError::Device {
                adapter: info.name.clone(),
                reason: error.to_string(),
            })?;
        Ok(Self { device, queue, info })
    }
}

fn preference(kind: wgpu::DeviceType) -> u8 {
    match kind {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    }
}

#[cfg(test)]
mod tests {
    use crate::RenderError;
    use crate::kernel_tests::gpu;

    fn texture(side: u32, layers: u32) -> wgpu::Texture {
        gpu().device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: layers },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba32Uint,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        })
    }

    #[test]
    fn what_the_driver_refuses_is_an_error() {
        let limits = gpu().device.limits();
        let (side, layers) = (limits.max_texture_dimension_2d, limits.max_texture_array_layers);
        let made = |side: u32, layers: u32| gpu().watched(|| Ok(texture(side, layers)));
        // Hundreds of gigabytes.
        assert!(matches!(made(side, layers), Err(RenderError::DeviceMemory)));
        assert!(matches!(made(side + 1, 1), Err(RenderError::Driver(_))));
        made(1, 1).expect("the device can still be used");
    }
}
