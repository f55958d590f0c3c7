//! Groups of resources that shaders are bound to.

use crate::Gpu;

/// Resources, bound in their order from 0.
pub(crate) type Bindings<'a> = Vec<wgpu::BindingResource<'a>>;

/// A group of resources, bound in their order from 0.
pub(crate) fn bind_group<'a>(
    gpu: &Gpu,
    label: &str,
    layout: &wgpu::BindGroupLayout,
    resources: impl IntoIterator<Item = wgpu::BindingResource<'a>>,
) -> wgpu::BindGroup {
    bind_group_at(gpu, label, layout, (0..).zip(resources))
}

/// The same, each bound where it says.
pub(crate) fn bind_group_at<'a>(
    gpu: &Gpu,
    label: &str,
    layout: &wgpu::BindGroupLayout,
    resources: impl IntoIterator<Item = (u32, wgpu::BindingResource<'a>)>,
) -> wgpu::BindGroup {
    let entries: Vec<_> = resources
        .into_iter()
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
        .collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some(label),
        layout,
        entries: &entries,
    })
}
