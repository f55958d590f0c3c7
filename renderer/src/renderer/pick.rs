//! What a pixel of the last frame shows.

use std::collections::BTreeMap;

use flaneur_scene::{ImageId, PointNodeId, View};
use glam::DVec2;

use super::Renderer;
use crate::RenderError;
use crate::depth_map::reference::Occluders;
use crate::depth_map::{self, Sources};
use crate::photographs::Photograph;
use crate::pick::{Asked, MOST_ASKED, Picked, Recorded, Sight, Texel, Texels, Words, shared_out};
use crate::shade::photograph::Standing;

/// What is read of a photograph: mesh, its uncertainty and point at four texels of its depth map; and a
/// texel of its own.
struct Looked {
    known: [[Texel; 3]; 4],
    own: Texel,
}

impl Renderer {
    /// What `pixel` of the last frame shows; `None` where that is nothing, or was inferred. The
    /// centre of the first pixel is (0.5, 0.5).
    ///
    /// # Errors
    /// Where the driver fails.
    pub fn pick(&mut self, pixel: DVec2) -> Result<Option<Picked>, RenderError> {
        self.gpu.clone().watched(|| self.picked(pixel))
    }

    fn picked(&mut self, pixel: DVec2) -> Result<Option<Picked>, RenderError> {
        let Some((view, whole)) = self.last else { return Ok(None) };
        let pixel = pixel * view.size().as_dvec2() / whole.as_dvec2();
        let Some(recorded) = self.recorded(&view, pixel)? else { return Ok(None) };
        let seen_by = self.sights(&view, &recorded)?;
        let Recorded { position, shown, surface, uncertainty_m } = recorded;
        Ok(Some(Picked { position, normal: shown.normal, uncertainty_m, surface, seen_by }))
    }

    /// The nodes whose points are resident: those that a picked point may be of.
    pub fn point_nodes(&self) -> impl Iterator<Item = PointNodeId> + '_ {
        self.points.nodes()
    }

    fn recorded(&self, view: &View, pixel: DVec2) -> Result<Option<Recorded>, RenderError> {
        let inside = pixel.cmpge(DVec2::ZERO).all() && pixel.cmplt(view.size().as_dvec2()).all();
        let (Some(targets), true) = (&self.targets, inside) else { return Ok(None) };
        let (records, at) = (&targets.records, pixel.as_uvec2());
        let mut texels = Texels::new(&self.gpu);
        let position = texels.one(records.positions.texture(), at, 0);
        let orientation = texels.one(records.orientations.texture(), at, 0);
        let words = texels.read(&self.gpu)?;
        Ok(Recorded::new(view, pixel, words.words(position), words.words(orientation)))
    }

    /// The photographs that see a place. Maps that no frame has needed are drawn now.
    fn sights(&mut self, view: &View, recorded: &Recorded) -> Result<Vec<Sight>, RenderError> {
        let eye = view.eye();
        let rigs = self.photographs.nearest(eye, self.settings.rigs);
        let standings: BTreeMap<&ImageId, Standing> =
            rigs.into_iter().map(|(id, _, standing)| (id, standing)).collect();
        let mut asked: Vec<Asked<'_>> = self
            .photographs
            .iter()
            .filter_map(|(id, photograph)| {
                Asked::new(id, photograph, standings.get(id).copied(), recorded.position)
            })
            .collect();
        asked.sort_by(|a, b| a.distance_m().total_cmp(&b.distance_m()));
        asked.truncate(self.maps.max_maps().min(MOST_ASKED));

        let selected: Vec<(&ImageId, &Photograph)> =
            asked.iter().map(|asked| (asked.id, asked.photograph)).collect();
        // Points may have come since the last frame.
        self.points.upload(&self.gpu);
        let sources = Sources {
            mesh_pass: &self.mesh_pass,
            splat_pass: &self.splat_pass,
            mesh: &self.mesh,
            points: &self.points,
        };
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        self.maps.prepare(&self.gpu, &mut encoder, &sources, &selected);
        self.gpu.queue.submit([encoder.finish()]);

        let mut texels = Texels::new(&self.gpu);
        let looked: Vec<Option<Looked>> = asked
            .iter()
            .map(|asked| {
                let layer = self.maps.place(asked.id)?.layer;
                let [mesh, points] = self.maps.textures();
                let known = asked.map_texels().map(|at| {
                    [(mesh, 2 * layer), (mesh, 2 * layer + 1), (points, layer)]
                        .map(|(texture, layer)| texels.one(texture, at, layer))
                });
                let (texture, layer, at) = self.photographs.texel(asked.photograph, asked.pixel);
                Some(Looked { known, own: texels.one(texture, at, layer) })
            })
            .collect();
        let words = texels.read(&self.gpu)?;
        let weighed = asked.iter().zip(looked).filter_map(|(asked, looked)| {
            let Looked { known, own } = looked?;
            let [rgba] = words.words(own);
            let inside = f64::from(rgba >> 24) / 255.0;
            let known = known.map(|texel| occluders(&words, texel));
            Some(asked.weighed(eye, recorded, known, inside))
        });
        Ok(shared_out(weighed.collect()))
    }
}

fn occluders(words: &Words, texels: [Texel; 3]) -> Occluders {
    let [mesh_m, behind_m, point] = texels.map(|texel| {
        let [word] = words.words(texel);
        f32::from_bits(word)
    });
    Occluders {
        mesh_m: mesh_m.into(),
        mesh_uncertainty_m: f64::from(behind_m) - f64::from(mesh_m),
        point_m: depth_map::reference::nearest_point_m(point),
    }
}
