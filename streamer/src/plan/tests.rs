//! Any order of arrivals, failures and views: what the receiver holds never has a hole that it need
//! not have, and comes to what the last view wants.

use std::sync::Arc;

use flaneur_scene::{
    ImageUpdate, Intrinsics, Lens, MeshTile, MeshVertex, NodeKey, PointChunk, PointStations,
    PosedCamera, SurfaceClass, TileLayer,
};
use glam::{DMat3, DVec3, UVec2};
use proptest::prelude::*;

use super::*;

/// A small scene: a street of cells along which one looks at places.
const PLACES: i32 = 6;
/// Levels of every image, and of the octree.
const LEVELS: u32 = 4;

fn image_id(place: i32) -> ImageId {
    ImageId::new(&format!("p{place}"), "c").expect("a name")
}

fn tile(place: i32) -> TileKey {
    TileKey { layer: TileLayer::Ground, x: place, y: 0 }
}

fn node(level: u32, x: u32) -> PointNodeId {
    PointNodeId { source: 0, key: NodeKey { level, x, y: 0, z: 0 } }
}

/// What `plan` is to want at `place`, as far as it is known what there is: the rest once it is.
fn known_wishes(place: i32, exact: bool, plan: &Plan) -> Wishes {
    let survey = Want {
        part: Part::Panoramas((place, 0)),
        stage: Stage::First,
        bytes: 50,
        gain: f64::MAX,
        distance_m: 0.0,
        photographs: [].into(),
        exact,
    };
    let mut wishes = wishes(place, exact);
    wishes.open = !plan.knows(&survey.part);
    if wishes.open {
        wishes.wants.retain(|want| !matches!(want.part, Part::Image { .. }));
        wishes.images.clear();
    }
    wishes.wants.push(survey);
    // Someone goes on: what lies ahead is fetched, and not shown.
    let wanted: BTreeSet<Part> = wishes.wants.iter().map(|want| want.part.clone()).collect();
    let later = self::wishes((place + 3) % PLACES, exact).wants.into_iter();
    let later = later.filter(|want| !wanted.contains(&want.part));
    wishes.wants.extend(later.map(|want| Want { stage: Stage::Ahead, ..want }));
    wishes
}

/// What is wanted at `place`: the tiles and images next to it, terrain finer where it is near, and
/// nodes down to the bottom there.
fn wishes(place: i32, exact: bool) -> Wishes {
    let mut wishes = Wishes { most: (40, 4000), ..Wishes::default() };
    let want = |part: Part, stage, bytes| Want {
        part,
        stage,
        bytes,
        gain: 1.0,
        distance_m: 1.0,
        photographs: [].into(),
        exact,
    };
    for near in (place - 2).max(0)..=(place + 2).min(PLACES - 1) {
        let away = near.abs_diff(place);
        let part = Part::Mesh { key: tile(near), step: 1 << away };
        wishes.wants.push(want(part, Stage::First, 100));
        wishes.tiles.insert(tile(near));
    }
    for near in (place - 1).max(0)..=(place + 1).min(PLACES - 1) {
        let finest = if near == place { 0 } else { 1 };
        for level in [LEVELS - 1, LEVELS - 2, finest] {
            let part = Part::Image { panorama: format!("p{near}").into(), camera: 0, level };
            let stage = if level < LEVELS - 1 { Stage::Detail } else { Stage::First };
            wishes.wants.push(Want {
                photographs: [image_id(near)].into(),
                exact: exact && level == finest,
                ..want(part, stage, 1000 >> level)
            });
        }
        wishes.images.insert(image_id(near));
    }
    for level in 0..LEVELS {
        let id = node(level, place as u32 >> (LEVELS - 1 - level));
        wishes.wants.push(want(Part::Node(id), Stage::Detail, 500));
        wishes.nodes.insert(id);
    }
    wishes
}

/// What comes of a part.
fn updates(part: &Part) -> Vec<SceneUpdate> {
    match part {
        Part::Mesh { key, .. } => {
            let vertex = MeshVertex {
                position: [0.0; 3],
                normal: [0.0, 0.0, 1.0],
                uncertainty_m: 0.1,
                class: SurfaceClass::Ground,
            };
            let mesh = MeshTile {
                key: *key,
                origin: DVec3::ZERO,
                vertices: vec![vertex; 3],
                indices: vec![0, 1, 2],
            };
            vec![SceneUpdate::Mesh(Arc::new(mesh))]
        }
        Part::Image { panorama, level, .. } => {
            let size = UVec2::splat(32 >> level);
            let lens = Lens::pinhole(size, Intrinsics::from_fov_y(1.0, size));
            let camera = PosedCamera { centre: DVec3::ZERO, cam_from_world: DMat3::IDENTITY, lens };
            vec![SceneUpdate::Image(Arc::new(ImageUpdate {
                id: ImageId::new(panorama, "c").expect("a name"),
                level: *level,
                camera,
                size,
                rgba: vec![0; 4 * (size.x * size.y) as usize],
                uncertainty_m: 0.0,
            }))]
        }
        Part::Node(id) => vec![SceneUpdate::Points(Arc::new(PointChunk {
            id: *id,
            origin: DVec3::ZERO,
            positions: vec![[0.0; 3]; 10],
            colours: Vec::new(),
            intensities: Vec::new(),
            classes: Vec::new(),
            normals: Vec::new(),
            stations: PointStations::default(),
            spacing_m: 1.0,
            spacings_m: Vec::new(),
        }))],
        _ => Vec::new(),
    }
}

/// A receiver that checks what it is told.
#[derive(Default)]
struct Receiver {
    held: Held,
    /// How coarse each tile was when it came last.
    steps: BTreeMap<TileKey, u32>,
}

impl Receiver {
    /// What came of a part: every step leaves a picture that is no worse where the view looks than the
    /// one before.
    fn take(&mut self, part: &Part, plan: &mut Plan) -> Result<(), TestCaseError> {
        let is_ahead =
            plan.wishes.wants.iter().any(|want| want.part == *part && want.stage == Stage::Ahead);
        let told = plan.arrive(part, updates(part)).unwrap_or_default();
        prop_assert!(!is_ahead || told.is_empty(), "what lies ahead is shown: {part:?}");
        if let (Part::Mesh { key, step }, false) = (part, told.is_empty()) {
            let wanted = plan.wishes.wants.iter().any(|want| want.part == *part);
            prop_assert!(wanted, "nobody wants {key:?} at {step}");
            let before = self.steps.insert(*key, *step);
            let better = before != Some(*step) || !self.held.tiles.contains(key);
            prop_assert!(better, "sent twice: {key:?} at {step}");
        }
        self.tell(&told, plan)
    }

    fn tell(&mut self, told: &[SceneUpdate], plan: &Plan) -> Result<(), TestCaseError> {
        for update in told {
            match update {
                SceneUpdate::DropMesh(key) => {
                    prop_assert!(!plan.wishes.tiles.contains(key), "a hole in the ground: {key:?}");
                    prop_assert!(self.held.tiles.contains(key), "dropped twice: {key:?}");
                }
                SceneUpdate::DropImage(id) => {
                    prop_assert!(!plan.wishes.images.contains(id), "a photograph goes: {id}");
                    prop_assert!(self.held.images.contains_key(id), "dropped twice: {id}");
                }
                SceneUpdate::DropPoints(id) => {
                    prop_assert!(!plan.wishes.nodes.contains(id), "points go: {id:?}");
                    prop_assert!(self.held.nodes.contains(id), "dropped twice: {id:?}");
                    let below = self.held.nodes.iter().any(|n| n.key.parent() == Some(id.key));
                    prop_assert!(!below, "finer points stay without coarser: {id:?}");
                }
                SceneUpdate::Image(image) => {
                    let before = self.held.images.get(&image.id);
                    let wanted = plan.wishes.images.contains(&image.id);
                    prop_assert!(wanted, "nobody wants {}", image.id);
                    let serves = |want: &Want| {
                        let is_level = |part: &Part| matches!(part, Part::Image { level, .. } if *level == image.level);
                        want.exact && is_level(&want.part) && want.photographs.contains(&image.id)
                    };
                    let exact = plan.wishes.wants.iter().any(serves);
                    // Coarser only where the view is to hold that level and no other.
                    prop_assert!(
                        before.is_none_or(|&(level, _)| {
                            level > image.level || exact && level != image.level
                        }),
                        "no better than before: {before:?}"
                    );
                }
                SceneUpdate::Points(chunk) => {
                    prop_assert!(
                        !self.held.nodes.contains(&chunk.id),
                        "an overlap: {:?}",
                        chunk.id
                    );
                }
                SceneUpdate::Mesh(tile) => {
                    let key = tile.key;
                    prop_assert!(plan.wishes.tiles.contains(&key), "nobody wants {key:?}");
                }
            }
            self.held.note(update);
        }
        prop_assert_eq!(&self.held.tiles, &plan.held.tiles);
        prop_assert_eq!(&self.held.images, &plan.held.images);
        prop_assert_eq!(&self.held.nodes, &plan.held.nodes);
        Ok(())
    }
}

impl Receiver {
    /// Gives a photograph or a node up, or takes a photograph's coarsest level instead; then nothing
    /// of that comes again unless something else is looked at.
    fn decline(&mut self, index: prop::sample::Index, drop: bool, plan: &mut Plan) {
        let images: Vec<ImageId> = self.held.images.keys().cloned().collect();
        // The deepest nodes alone: a renderer that drops one drops what is below it.
        let leaves: Vec<PointNodeId> = self
            .held
            .nodes
            .iter()
            .copied()
            .filter(|id| !self.held.nodes.iter().any(|other| other.key.parent() == Some(id.key)))
            .collect();
        if drop && !leaves.is_empty() {
            let update = SceneUpdate::DropPoints(leaves[index.index(leaves.len())]);
            self.held.note(&update);
            plan.note(&update);
        } else if !images.is_empty() {
            let id = &images[index.index(images.len())];
            if let Some((level, _)) = self.held.images.get_mut(id) {
                *level = LEVELS - 1;
            }
            plan.note_level(id, LEVELS - 1);
        }
    }
}

#[derive(Clone, Debug)]
enum Step {
    Look(i32),
    /// Asks for more.
    Ask,
    /// One of the parts under way comes, or fails.
    Arrive(prop::sample::Index),
    Fail(prop::sample::Index, Verdict),
    /// The receiver drops something of what it holds, or makes it coarser.
    Decline(prop::sample::Index, bool),
}

fn verdict() -> impl Strategy<Value = Verdict> {
    prop_oneof![Just(Verdict::Again), Just(Verdict::Alone), Just(Verdict::Never)]
}

fn step() -> impl Strategy<Value = Step> {
    prop_oneof![
        1 => (0..PLACES).prop_map(Step::Look),
        4 => Just(Step::Ask),
        6 => any::<prop::sample::Index>().prop_map(Step::Arrive),
        1 => (any::<prop::sample::Index>(), verdict()).prop_map(|(i, verdict)| Step::Fail(i, verdict)),
        1 => (any::<prop::sample::Index>(), any::<bool>()).prop_map(|(i, drop)| Step::Decline(i, drop)),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]
    #[test]
    fn any_order_of_events_keeps_the_picture_whole(
        steps in prop::collection::vec(step(), 0..120),
        last in 0..PLACES, exact in any::<bool>(), order in any::<bool>(),
    ) {
        let order = if order { Order::ExpectedError } else { Order::NearestFirst };
        let mut plan = Plan::new(order);
        let mut receiver = Receiver::default();
        let mut under_way: Vec<(BatchId, Part)> = Vec::new();
        let mut here = None;
        for step in steps {
            match step {
                Step::Look(place) => {
                    here = Some(place);
                    let useless = plan.look(known_wishes(place, exact, &plan));
                    under_way.retain(|(batch, _)| !useless.contains(batch));
                }
                Step::Ask => {
                    if let Some(batch) = plan.next(Room { bytes: 1200, soon: 3000 }) {
                        let alone = batch.parts.iter().any(|part| plan.alone.contains(part));
                        prop_assert!(!alone || batch.parts.len() == 1, "in company: {batch:?}");
                        for part in batch.parts {
                            let twice = under_way.iter().any(|(_, other)| *other == part);
                            prop_assert!(!twice, "asked for twice: {part:?}");
                            under_way.push((batch.id, part));
                        }
                    }
                }
                Step::Arrive(index) if !under_way.is_empty() => {
                    let (_, part) = under_way.swap_remove(index.index(under_way.len()));
                    if part.is_survey() {
                        plan.learn(part);
                        let useless = here.map(|here| plan.look(known_wishes(here, exact, &plan)));
                        let useless = useless.unwrap_or_default();
                        under_way.retain(|(batch, _)| !useless.contains(batch));
                    } else {
                        receiver.take(&part, &mut plan)?;
                    }
                }
                Step::Fail(index, verdict) if !under_way.is_empty() => {
                    let (_, part) = under_way.swap_remove(index.index(under_way.len()));
                    plan.fail(&part, verdict);
                }
                Step::Arrive(_) | Step::Fail(..) => {}
                Step::Decline(index, drop) => receiver.decline(index, drop, &mut plan),
            }
            let standing = plan.standing();
            prop_assert!(!standing.finished || standing.complete_picture);
            // Above its limits only by what the view wants itself.
            let wanted: u64 = plan.wishes.nodes.len() as u64 * 10;
            prop_assert!(receiver.held.point_count() <= wanted.max(50 + 10));
        }

        // The network is sound from here on: everything comes, and nothing but what is wanted stays.
        plan.forgive();
        let useless = plan.look(known_wishes(last, exact, &plan));
        under_way.retain(|(batch, _)| !useless.contains(batch));
        for _ in 0..1000 {
            while let Some(batch) = plan.next(Room { bytes: 1200, soon: 3000 }) {
                under_way.extend(batch.parts.into_iter().map(|part| (batch.id, part)));
            }
            let Some((_, part)) = under_way.pop() else { break };
            if part.is_survey() {
                plan.learn(part);
                let useless = plan.look(known_wishes(last, exact, &plan));
                under_way.retain(|(batch, _)| !useless.contains(batch));
            } else {
                receiver.take(&part, &mut plan)?;
            }
        }
        prop_assert!(plan.standing().finished, "{:?}", plan.standing());
        let drops = plan.drops();
        receiver.tell(&drops, &plan)?;
        let wanted = wishes(last, exact);
        prop_assert_eq!(&receiver.held.tiles, &wanted.tiles);
        prop_assert_eq!(&receiver.held.nodes, &wanted.nodes);
        let finest = |id: &ImageId| u32::from(*id != image_id(last));
        for id in &wanted.images {
            let (level, _) = receiver.held.images[id];
            prop_assert!(level == finest(id) || (!exact && level < finest(id)), "{id} at {level}");
        }
        prop_assert_eq!(receiver.held.images.len(), wanted.images.len());
    }
}

#[test]
fn what_is_wanted_ahead_waits_for_all_else_and_is_fetched_once() {
    let mut plan = Plan::new(Order::ExpectedError);
    let mut now = wishes(0, true);
    let later = wishes(5, true).wants.into_iter();
    now.wants.extend(later.map(|want| Want { stage: Stage::Ahead, ..want }));
    assert!(plan.look(now).is_empty());
    let mut ahead = 0;
    while let Some(batch) = plan.next(Room { bytes: 1000, soon: 0 }) {
        for part in batch.parts {
            let told = plan.arrive(&part, updates(&part));
            if told.is_none() {
                assert!(plan.standing().finished, "too early: {part:?}");
                ahead += 1;
            }
        }
    }
    assert!(ahead > 0);
    assert_eq!(plan.held().images.len(), 2, "what is ahead is not shown");
}

#[test]
fn a_level_is_passed_over_whose_finer_one_comes_soon() {
    let asked = |soon: u64| {
        let mut plan = Plan::new(Order::ExpectedError);
        plan.look(wishes(0, true));
        let mut levels = Vec::new();
        while let Some(batch) = plan.next(Room { bytes: 1, soon }) {
            for part in batch.parts {
                if let Part::Image { panorama, level, .. } = &part
                    && &**panorama == "p0"
                {
                    levels.push(*level);
                }
                plan.arrive(&part, updates(&part));
            }
        }
        assert!(plan.standing().finished);
        levels
    };
    // All three levels of what is nearest, where the connection is slow.
    assert_eq!(asked(0), [LEVELS - 1, LEVELS - 2, 0]);
    // Then the coarse one, which makes the picture complete, and the finest.
    assert_eq!(asked(100_000), [LEVELS - 1, 0]);
}

#[test]
fn of_an_image_the_finest_level_is_fetched_ahead_and_shown_while_a_finer_one_comes() {
    let levels = |finest: u32, stage: &dyn Fn(u32) -> Stage| {
        let level = |level| {
            let want = detail(Part::Image { panorama: "p0".into(), camera: 0, level });
            Want { stage: stage(level), photographs: [image_id(0)].into(), ..want }
        };
        let wants = (finest..LEVELS).rev().map(level).collect();
        Wishes { wants, images: [image_id(0)].into(), most: (40, 4000), ..Wishes::default() }
    };
    let mut plan = Plan::new(Order::ExpectedError);
    let asked = |plan: &mut Plan| {
        let mut parts = Vec::new();
        while let Some(batch) = plan.next(Room { bytes: 1, soon: 100_000 }) {
            batch.parts.iter().for_each(|part| _ = plan.arrive(part, updates(part)));
            parts.extend(batch.parts);
        }
        let level = |part: Part| match part {
            Part::Image { level, .. } => level,
            other => panic!("{other:?} is no image"),
        };
        parts.into_iter().map(level).collect::<Vec<_>>()
    };
    plan.look(levels(1, &|_| Stage::Ahead));
    assert_eq!(asked(&mut plan), [1]);
    let first = |level| if level == LEVELS - 1 { Stage::First } else { Stage::Detail };
    plan.look(levels(0, &first));
    assert_eq!(asked(&mut plan), [LEVELS - 1, 1, 0]);
}

/// Who walks on and on may never see a view whole, and so hears of no drops at its end.
#[test]
fn tiles_left_behind_go_while_views_follow_one_another() {
    let mut plan = Plan::new(Order::default());
    let mut most = 0;
    for place in 0..40 {
        let mut wanted = Wishes { most: (40, 4000), ..Wishes::default() };
        wanted.tiles = (place..place + 5).map(tile).collect();
        let mesh = |key: &TileKey| Part::Mesh { key: *key, step: 1 };
        let parts: Vec<Part> = wanted.tiles.iter().map(mesh).collect();
        let never = Part::Node(node(0, 0));
        wanted.wants = parts.iter().chain([&never]).cloned().map(detail).collect();
        _ = plan.look(wanted);
        for part in parts {
            _ = plan.arrive(&part, updates(&part));
        }
        assert!(!plan.standing().finished);
        assert!(plan.wishes.tiles.is_subset(&plan.held.tiles));
        most = most.max(plan.held.tiles.len());
    }
    assert_eq!(most, 6, "five are wanted at once, and a quarter more may stay");
}

fn detail(part: Part) -> Want {
    let (stage, photographs) = (Stage::Detail, [].into());
    Want { part, stage, bytes: 100, gain: 1.0, distance_m: 1.0, photographs, exact: false }
}
