//! The methods at work.

use std::collections::BTreeSet;
use std::sync::Arc;

use flaneur_renderer::{Gpu, MemoryReport, Renderer, Settings, SplatNormals};
use flaneur_scene::{ImageId, PosedCamera, View};
use flaneur_streamer::{Event, FetchLimits, Streamer, ViewRequest};
use futures::StreamExt;

use super::Context;
use super::target::stored;
use crate::evaluation::{Compared, Making, Method};
use crate::exit::Exit;
use crate::memory::GpuMemory;
use crate::names::Names;
use crate::source::{note, stream_exit};

/// Methods that one renderer serves in turn, because they are given the same geometry and differ
/// only in what is decided anew for each frame; or those that need none.
pub(super) struct Group {
    rendered: Option<Rendered>,
    members: Vec<Member>,
}

/// What a group's renderer is made with.
#[derive(Clone, Copy)]
struct Rendered {
    making: Making,
    settings: Settings,
}

/// One method.
pub(super) struct Member {
    /// Its place among all methods of the evaluation.
    pub(super) place: usize,
    /// The method.
    pub(super) method: &'static Method,
    settings: Option<Settings>,
}

/// A group with what is resident for it.
pub(super) struct Contender {
    rendered: Option<(Making, Renderer)>,
    streamer: Streamer,
    gpu_memory: GpuMemory,
}

impl Group {
    /// The methods by groups, whose settings start from `whole`.
    pub(super) fn all(methods: &[&'static Method], whole: Settings) -> Vec<Self> {
        let mut groups: Vec<Self> = Vec::new();
        for (place, &method) in methods.iter().enumerate() {
            let settings = method.making.settings(whole);
            let member = Member { place, method, settings };
            let rendered = settings.map(|settings| Rendered { making: method.making, settings });
            match groups.iter_mut().find(|group| group.serves(rendered)) {
                Some(group) => group.members.push(member),
                None => groups.push(Self { rendered, members: vec![member] }),
            }
        }
        groups
    }

    /// Its methods, in the order of their places.
    pub(super) fn members(&self) -> &[Member] {
        &self.members
    }

    fn serves(&self, other: Option<Rendered>) -> bool {
        match (self.rendered, other) {
            (None, None) => true,
            (Some(a), Some(b)) => {
                a.making.takes_as(&b.making) && a.settings.differ_by_frame_only(&b.settings)
            }
            _ => false,
        }
    }
}

impl Contender {
    /// The group with nothing resident. `gpu` may be missing where it does not render.
    pub(super) fn new(
        group: &Group,
        gpu: Option<&Gpu>,
        streamer: Streamer,
        gpu_memory: GpuMemory,
    ) -> Self {
        let rendered = group.rendered.zip(gpu).map(|(Rendered { making, settings }, gpu)| {
            (making, Renderer::with_settings(gpu, settings))
        });
        Self { rendered, streamer, gpu_memory }
    }

    /// Brings everything that the view of `camera` wants of `sources`, where the group renders.
    pub(super) async fn fetch(
        &mut self,
        camera: PosedCamera,
        sources: &Arc<BTreeSet<ImageId>>,
        context: &Context,
    ) -> Result<(), Exit> {
        let Some((making, renderer)) = &mut self.rendered else { return Ok(()) };
        renderer.expect_eye(camera.centre);
        let sources = Arc::clone(sources);
        let request = ViewRequest {
            excluded: Arc::new(move |id| !sources.contains(id)),
            normals: renderer.settings().splat_normals == SplatNormals::Estimated,
            limits: self.gpu_memory.fitted(FetchLimits::default()),
            ..ViewRequest::new(View::from(camera))
        };
        let mut events = self.streamer.stream(request, &context.cancel);
        while let Some(event) = events.next().await {
            match event.map_err(stream_exit)? {
                Event::Update(update) if making.takes(&update) => {
                    let applied = tokio::task::block_in_place(|| renderer.apply(update))?;
                    note(&mut events, &applied);
                }
                Event::Update(_) | Event::Progress(_) | Event::Fault { .. } => {}
            }
        }
        Ok(())
    }

    /// What is held on the device.
    pub(super) fn memory(&self) -> MemoryReport {
        self.rendered.as_ref().map_or_else(MemoryReport::default, |(_, of)| of.memory())
    }

    /// The picture that `camera` would take by `member`, of the camera's size. `nearest` is the
    /// source that a method without a renderer shows.
    pub(super) async fn picture(
        &mut self,
        member: &Member,
        camera: &PosedCamera,
        nearest: &ImageId,
        names: &Names,
    ) -> Result<Compared, Exit> {
        match self.rendered.as_mut().zip(member.settings) {
            Some(((_, renderer), settings)) => tokio::task::block_in_place(|| {
                renderer.set_settings(settings);
                renderer.cut();
                let frame = renderer.render(&View::from(*camera))?;
                Ok(Compared::from(&frame))
            }),
            None => {
                let source = stored(nearest, names, &self.streamer).await?;
                Ok(tokio::task::block_in_place(|| source.resized(camera.lens.size)))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::METHODS;

    #[test]
    fn methods_share_a_renderer_where_only_the_frame_differs() {
        let all: Vec<&'static Method> = METHODS.iter().collect();
        let groups = Group::all(&all, Settings::default());
        let of = |name: &str| {
            let is = |member: &Member| member.method.name == name;
            groups.iter().position(|group| group.members().iter().any(is)).expect("in a group")
        };
        assert_eq!(of("hybrid"), of("hybrid-without-alignment"));
        for apart in ["nearest", "mesh", "points", "hybrid-without-refinement"] {
            assert_ne!(of("hybrid"), of(apart), "{apart}");
        }
        let mut places: Vec<usize> =
            groups.iter().flat_map(|group| group.members()).map(|member| member.place).collect();
        places.sort_unstable();
        assert_eq!(places, (0..METHODS.len()).collect::<Vec<_>>());
        for group in &groups {
            let renders = |member: &Member| member.settings.is_some();
            assert!(
                group.members().iter().all(|member| renders(member) == group.rendered.is_some())
            );
        }
    }
}
