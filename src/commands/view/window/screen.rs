//! The window's surface, and the device that fills it: not the painter's, so that neither waits for
//! the other.

use std::sync::Arc;

use anyhow::Context;
use flaneur_scene::View;
use glam::UVec2;
use winit::event_loop::OwnedDisplayHandle;
use winit::window::Window;

use super::picture::Picture;
use crate::commands::view::painter::Shown;

/// What stands behind the picture before there is one.
const BEHIND: wgpu::Color = wgpu::Color { r: 0.13, g: 0.14, b: 0.16, a: 1.0 };

/// A surface with what is drawn on it.
pub(super) struct Screen {
    instance: wgpu::Instance,
    window: Arc<Window>,
    surface: wgpu::Surface<'static>,
    configuration: wgpu::SurfaceConfiguration,
    /// Of what is drawn: as it is shown, whatever the surface would make of it.
    format: wgpu::TextureFormat,
    device: wgpu::Device,
    queue: wgpu::Queue,
    picture: Picture,
    panels: egui_wgpu::Renderer,
}

/// Panels to be drawn.
pub(super) struct Panels {
    pub(super) primitives: Vec<egui::ClippedPrimitive>,
    pub(super) textures: egui::TexturesDelta,
    pub(super) pixels_per_point: f32,
}

impl Screen {
    /// Opens the window's surface.
    pub(super) fn new(window: Arc<Window>, display: OwnedDisplayHandle) -> anyhow::Result<Self> {
        let descriptor = wgpu::InstanceDescriptor::new_with_display_handle(Box::new(display));
        let instance = wgpu::Instance::new(descriptor);
        let surface = instance.create_surface(Arc::clone(&window))?;
        // Whatever shows the desktop will do: the work is done elsewhere.
        let (adapter, device, queue) = pollster::block_on(async {
            let adapter = instance
                .request_adapter(&wgpu::RequestAdapterOptions {
                    power_preference: wgpu::PowerPreference::LowPower,
                    compatible_surface: Some(&surface),
                    ..Default::default()
                })
                .await
                .context("no graphics driver can show a window here")?;
            let limits = wgpu::Limits::downlevel_defaults().using_resolution(adapter.limits());
            let (device, queue) = adapter
                .request_device(&wgpu::DeviceDescriptor {
                    label: Some("window"),
                    required_limits: limits,
                    ..Default::default()
                })
                .await?;
            anyhow::Ok((adapter, device, queue))
        })?;
        let size = size_of(&window);
        let mut configuration = surface
            .get_default_config(&adapter, size.x, size.y)
            .context("the graphics driver cannot show this window")?;
        let formats = surface.get_capabilities(&adapter).formats;
        configuration.format = egui_wgpu::preferred_framebuffer_format(&formats)?;
        configuration.present_mode = wgpu::PresentMode::AutoVsync;
        let format = configuration.format.remove_srgb_suffix();
        configuration.view_formats = vec![format];
        surface.configure(&device, &configuration);
        let options = egui_wgpu::RendererOptions { dithering: false, ..Default::default() };
        Ok(Self {
            instance,
            window,
            surface,
            configuration,
            format,
            picture: Picture::new(&device, format),
            panels: egui_wgpu::Renderer::new(&device, format, options),
            device,
            queue,
        })
    }

    /// Size in pixels, at least one.
    pub(super) fn size(&self) -> UVec2 {
        UVec2::new(self.configuration.width, self.configuration.height)
    }

    /// Longest side of a texture, pixels.
    pub(super) fn max_side(&self) -> u32 {
        self.device.limits().max_texture_dimension_2d
    }

    /// The window has another size.
    pub(super) fn resize(&mut self) {
        let size = size_of(&self.window).min(UVec2::splat(self.max_side()));
        (self.configuration.width, self.configuration.height) = (size.x, size.y);
        self.surface.configure(&self.device, &self.configuration);
    }

    /// Shows a new frame from now on; none before the first.
    pub(super) fn show(&mut self, shown: &Shown) {
        if shown.size.max_element() <= self.max_side() {
            self.picture.show(&self.device, &self.queue, shown);
        }
    }

    /// Shows none any more.
    pub(super) fn clear(&mut self) {
        self.picture.clear();
    }

    /// Draws the picture as `view` sees it, with panels before it. Where the window cannot be drawn
    /// on at the moment, nothing happens.
    pub(super) fn draw(&mut self, view: &View, panels: Panels) -> anyhow::Result<()> {
        let Panels { primitives, mut textures, pixels_per_point } = panels;
        let size = self.size();
        let descriptor =
            egui_wgpu::ScreenDescriptor { size_in_pixels: size.to_array(), pixels_per_point };
        for (id, deltas) in textures.set.drain() {
            for delta in deltas {
                self.panels.update_texture(&self.device, &self.queue, id, &delta);
            }
        }
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let mut commands = self.panels.update_buffers(
            &self.device,
            &self.queue,
            &mut encoder,
            &primitives,
            &descriptor,
        );
        let target = self.next_target()?;
        if let Some(target) = &target {
            let texture_view = target.texture.create_view(&wgpu::TextureViewDescriptor {
                format: Some(self.format),
                ..Default::default()
            });
            let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("window"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &texture_view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(BEHIND),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                ..Default::default()
            });
            let mut pass = pass.forget_lifetime();
            self.picture.draw(&self.queue, &mut pass, view);
            self.panels.render(&mut pass, &primitives, &descriptor);
        }
        commands.push(encoder.finish());
        self.queue.submit(commands);
        for id in textures.free.drain() {
            self.panels.free_texture(&id);
        }
        if let Some(target) = target {
            self.window.pre_present_notify();
            self.queue.present(target);
        }
        Ok(())
    }

    fn next_target(&mut self) -> anyhow::Result<Option<wgpu::SurfaceTexture>> {
        use wgpu::CurrentSurfaceTexture::{
            Lost, Occluded, Outdated, Suboptimal, Success, Timeout, Validation,
        };
        for _ in 0..2 {
            match self.surface.get_current_texture() {
                Success(texture) | Suboptimal(texture) => return Ok(Some(texture)),
                Timeout | Occluded | Validation => return Ok(None),
                Outdated => self.surface.configure(&self.device, &self.configuration),
                Lost => {
                    self.surface = self.instance.create_surface(Arc::clone(&self.window))?;
                    self.surface.configure(&self.device, &self.configuration);
                }
            }
        }
        Ok(None)
    }
}

fn size_of(window: &Window) -> UVec2 {
    let size = window.inner_size();
    UVec2::new(size.width, size.height).max(UVec2::ONE)
}
