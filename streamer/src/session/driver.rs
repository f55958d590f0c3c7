//! The task behind a streamer: it asks the plan what to do, has it done, and tells the plan what
//! came of it.

use std::collections::{HashMap, VecDeque};
use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use flaneur_scene::{ImageId, SceneUpdate};
use tokio::sync::mpsc;
use tokio::time::Instant;

use super::motion::Motion;
use super::statistics::{Counts, add, sub};
use super::understand::{Context, Understood, understand};
use crate::cache::WorkingSet;
use crate::decode::decoded;
use crate::load::{Interest, Landed, Loader, Origin};
use crate::plan::{Batch, BatchId, Order, Part, Plan, Verdict};
use crate::survey::{Survey, Target, Targets, wishes};
use crate::{Event, Progress, StreamError, ViewRequest};

/// Events that wait for the receiver before nothing more is asked for.
const WAITING: usize = 64;
/// How long what could not be had is not asked for again while someone walks.
const GRUDGE: Duration = Duration::from_secs(10);
/// How long nothing at all may come before someone is told.
const PATIENCE: Duration = Duration::from_secs(30);

/// How often a server may say of a part that it cannot be had now, in one view: beyond that it is not
/// the moment that is at fault.
const MOST_EXCUSES: u32 = 12;

/// Most parts that are remembered as not used yet.
const MOST_UNUSED: usize = 1 << 16;

/// What a streamer asks of its driver.
#[derive(Debug)]
pub(crate) enum Command {
    /// Look at this; `None` fetches nothing any more. With the number of the view.
    Look(u64, Option<Box<ViewRequest>>),
    /// The receiver did this by itself.
    Note(SceneUpdate),
    /// The receiver holds a photograph at this level.
    NoteLevel(ImageId, u32),
}

/// A request under way.
#[derive(Debug)]
struct Open {
    _interest: Interest,
    /// Parts that have not landed.
    left: usize,
    /// Whether it asked for one part alone.
    single: bool,
}

/// What decoding gave.
#[derive(Debug)]
struct Decoded {
    part: Part,
    bytes: u64,
    origin: Origin,
    outcome: Result<Understood, StreamError>,
}

/// What happens next.
enum Step {
    Obey(Command),
    Land(Landed),
    Take(Decoded),
    /// More may be asked for.
    Ask,
    /// There is room for an event.
    Tell,
    /// The streamer has gone.
    End,
}

/// The state of one session.
pub(crate) struct Driver {
    loader: Arc<Loader>,
    survey: Survey,
    plan: Plan,
    view: u64,
    request: Option<ViewRequest>,
    motion: Motion,
    targets: Targets,
    open: HashMap<BatchId, Open>,
    batch_of: HashMap<Part, BatchId>,
    /// Payloads that wait for a mask or stations.
    parked: Vec<(Part, Bytes, Origin)>,
    /// How often a part was damaged.
    damages: HashMap<Part, u32>,
    /// How often a server said that it cannot give a part now.
    excuses: HashMap<Part, u32>,
    /// Bytes that came and are not used, by part.
    unused: HashMap<Part, u64>,
    heard: Instant,
    /// When what could not be had was last forgotten.
    forgiven: Instant,
    /// Whether more is known than was chosen by.
    learnt: bool,
    /// Bytes that the view had to ask for.
    asked_bytes: u64,
    working_set: WorkingSet,
    /// Whether the view was chosen by what its mesh shows.
    sighted: bool,
    /// Bytes received when the view's picture was complete.
    complete_at: Option<u64>,
    /// Whether the view's end was told.
    told: bool,
    outbox: VecDeque<Event>,
    events: mpsc::Sender<Event>,
    commands: mpsc::UnboundedReceiver<Command>,
    landed: (mpsc::UnboundedSender<Landed>, mpsc::UnboundedReceiver<Landed>),
    decoded: (mpsc::UnboundedSender<Decoded>, mpsc::UnboundedReceiver<Decoded>),
    counts: Arc<Counts>,
}

impl Driver {
    pub(crate) fn new(
        loader: Arc<Loader>,
        order: Order,
        counts: Arc<Counts>,
        commands: mpsc::UnboundedReceiver<Command>,
        events: mpsc::Sender<Event>,
    ) -> Self {
        let working_set = loader.cache().working_set();
        Self {
            survey: Survey::new(Arc::clone(loader.scene())),
            loader,
            plan: Plan::new(order),
            view: 0,
            request: None,
            motion: Motion::default(),
            targets: Targets::new(),
            open: HashMap::new(),
            batch_of: HashMap::new(),
            parked: Vec::new(),
            damages: HashMap::new(),
            excuses: HashMap::new(),
            unused: HashMap::new(),
            heard: Instant::now(),
            forgiven: Instant::now(),
            learnt: false,
            asked_bytes: 0,
            working_set,
            sighted: false,
            complete_at: None,
            told: true,
            outbox: VecDeque::new(),
            events,
            commands,
            landed: mpsc::unbounded_channel(),
            decoded: mpsc::unbounded_channel(),
            counts,
        }
    }

    /// Works until the streamer has gone.
    pub(crate) async fn run(mut self) {
        let freed = self.loader.freed();
        loop {
            // Listens before it looks, so that room that is made meanwhile is noticed.
            let mut room = std::pin::pin!(freed.notified());
            room.as_mut().enable();
            self.ask();
            let has_news = !self.outbox.is_empty();
            let step = tokio::select! {
                command = self.commands.recv() => command.map_or(Step::End, Step::Obey),
                room = self.events.reserve(), if has_news => {
                    room.map_or(Step::End, |_| Step::Tell)
                }
                () = room => Step::Ask,
                Some(landed) = self.landed.1.recv() => Step::Land(landed),
                Some(decoded) = self.decoded.1.recv() => Step::Take(decoded),
            };
            match step {
                Step::Obey(command) => self.obey_all(command),
                Step::Land(landed) => self.land(landed),
                Step::Take(decoded) => {
                    self.take(decoded);
                    while let Ok(decoded) = self.decoded.1.try_recv() {
                        self.take(decoded);
                    }
                    self.catch_up();
                }
                Step::Tell => {
                    // Nobody else sends, so the room is still there.
                    let sent = self.outbox.pop_front().map(|event| self.events.try_send(event));
                    if sent.is_some_and(|sent| sent.is_err()) {
                        return;
                    }
                }
                Step::Ask => {}
                Step::End => return,
            }
        }
    }

    /// Obeys a command and those behind it; of several views only the last one counts.
    fn obey_all(&mut self, command: Command) {
        let mut commands = vec![command];
        while let Ok(command) = self.commands.try_recv() {
            commands.push(command);
        }
        let is_look = |command: &Command| matches!(command, Command::Look(..));
        let last = commands.iter().rposition(is_look);
        for (index, command) in commands.into_iter().enumerate() {
            if !is_look(&command) || Some(index) == last {
                self.obey(command);
            }
        }
    }

    fn obey(&mut self, command: Command) {
        match command {
            Command::Look(view, request) => {
                // Of several views only the last one counts.
                self.view = view;
                self.request = request.map(|request| *request);
                self.told = self.request.is_none();
                self.complete_at = None;
                self.heard = Instant::now();
                self.asked_bytes = 0;
                // Who walks looks many times a second: what failed is not worth trying at each.
                let walks = self.request.as_ref().is_some_and(|request| request.steadiness > 1.0);
                if !walks || self.forgiven.elapsed() > GRUDGE {
                    self.forgiven = self.heard;
                    self.plan.forgive();
                    self.damages.clear();
                    self.excuses.clear();
                }
                if let Some(request) = &self.request {
                    self.motion.note(&request.view, self.heard);
                }
                self.choose();
                if let Some(request) = &self.request {
                    // Once a view: what is forgotten and wanted after all comes once more, not for ever.
                    let forgotten = self.survey.forget(request, &self.targets);
                    forgotten.iter().for_each(|part| self.plan.unlearn(part));
                }
                self.sighted = self.plan.standing().complete_picture;
            }
            Command::Note(update) => {
                self.survey.surfaces.note(&update);
                self.plan.note(&update);
            }
            Command::NoteLevel(id, level) => self.plan.note_level(&id, level),
        }
        self.report();
    }

    /// Finds out anew what is wanted, and ends what is not any more.
    fn choose(&mut self) {
        let wishes = match &self.request {
            None => Ok(Default::default()),
            Some(request) => {
                let ahead = (request.steadiness > 1.0)
                    .then(|| self.motion.ahead(&request.view))
                    .flatten()
                    .map(|view| ViewRequest { view, ..request.clone() });
                let knows = |part: &Part| self.plan.knows(part);
                let held = self.plan.held();
                wishes(&self.survey, request, ahead.as_ref(), held, &knows)
            }
        };
        match wishes {
            Ok((wishes, targets)) => {
                self.targets = targets;
                for useless in self.plan.look(wishes) {
                    if self.open.remove(&useless).is_some() {
                        add(&self.counts.cancelled, 1);
                    }
                    self.batch_of.retain(|_, batch| *batch != useless);
                }
                // More may be missing once more of the survey is known, less never.
                self.asked_bytes = self.asked_bytes.max(self.plan.missing_bytes());
                self.working_set.set(self.asked_bytes);
            }
            Err(error) => self.fault(super::bad_id(&error)),
        }
    }

    /// Asks for as much as may be under way.
    fn ask(&mut self) {
        while self.request.is_some() && self.outbox.len() < WAITING {
            let Some(room) = self.loader.room() else { return };
            let Some(Batch { id, parts, bytes }) = self.plan.next(room) else { return };
            let single = parts.len() == 1;
            let left = parts.len();
            self.batch_of.extend(parts.iter().map(|part| (part.clone(), id)));
            let wanted = parts.into_iter().map(|part| {
                let target = self.targets.get(&part).cloned().unwrap_or(Target::Named);
                (part, target)
            });
            let interest = self.loader.load(id, wanted.collect(), bytes, self.landed.0.clone());
            self.open.insert(id, Open { _interest: interest, left, single });
        }
    }

    /// A payload has come, or not.
    fn land(&mut self, Landed { batch, part, payload, origin }: Landed) {
        let mut single = true;
        if self.batch_of.get(&part) == Some(&batch) {
            self.batch_of.remove(&part);
            if let Some(open) = self.open.get_mut(&batch) {
                single = open.single;
                open.left -= 1;
                if open.left == 0 {
                    self.open.remove(&batch);
                }
            }
        } else if payload.is_err() {
            // Of a request that was ended.
            return;
        }
        match payload {
            Ok(payload) => {
                self.heard = Instant::now();
                if origin.fetched {
                    if self.unused.len() >= MOST_UNUSED {
                        // They stay wasted.
                        self.unused.clear();
                    }
                    self.unused.insert(part.clone(), payload.len() as u64);
                    add(&self.counts.unused, payload.len() as u64);
                }
                self.decode(part, payload, origin);
            }
            Err(error) => self.trouble(&part, error, single),
        }
    }

    /// Has a payload decoded, if it is wanted, once what it takes is known.
    fn decode(&mut self, part: Part, payload: Bytes, origin: Origin) {
        let by_name = matches!(part, Part::Panoramas(_) | Part::Page(_) | Part::Stations(_));
        let target = self.targets.get(&part).cloned().or(by_name.then_some(Target::Named));
        let Some(target) = target else {
            self.plan.fail(&part, Verdict::Again);
            return;
        };
        let mut context = Context {
            scene: Arc::clone(&self.survey.scene),
            mask: None,
            track: None,
            normals: self.request.as_ref().is_some_and(|request| request.normals),
        };
        let needed = match (&part, &target) {
            (Part::Image { .. }, Target::Image(image, _)) => {
                image.rig_camera().mask.as_ref().map(|mask| {
                    let name: Arc<str> = mask.name.as_str().into();
                    context.mask = self.survey.masks.get(&name).cloned();
                    (context.mask.is_some(), Part::Mask(name))
                })
            }
            (Part::Node(id), _) => {
                context.track = self.survey.tracks.get(&id.source).cloned();
                Some((context.track.is_some(), Part::Stations(id.source)))
            }
            _ => None,
        };
        if let Some((false, needed)) = needed {
            if self.plan.knows(&needed) {
                // It cannot be had, and so this cannot be shown; that was said.
                self.plan.fail(&part, Verdict::Never);
                self.report();
            } else {
                self.parked.push((part, payload, origin));
            }
            return;
        }
        let sink = self.decoded.0.clone();
        tokio::spawn(async move {
            let (what, bytes) = (target.name(), payload.len() as u64);
            let of = part.clone();
            let outcome =
                decoded(&what, move || understand(&of, &target, &payload, &context)).await;
            drop(sink.send(Decoded { part, bytes, origin, outcome }));
        });
    }

    /// Something was understood, or not.
    fn take(&mut self, Decoded { part, bytes, origin, outcome }: Decoded) {
        match outcome {
            Ok(understood) => {
                if let Understood::Shown(updates) = understood {
                    if let Some(told) = self.plan.arrive(&part, updates) {
                        self.use_up(&part);
                        self.tell(told);
                    }
                } else {
                    self.learn(part, understood, origin);
                }
            }
            Err(error) => {
                if origin.fetched {
                    // It stays wasted, whatever comes the next time.
                    self.unused.remove(&part);
                }
                tracing::debug!(?part, bytes, %error, "a part cannot be used");
                self.loader.reject(&part, origin);
                self.trouble(&part, error, true);
            }
        }
        // What was learnt may make more wanted: that is found out before anything is said.
        if !self.learnt {
            self.report();
        }
    }

    /// Something of the survey is known, and so more can be wanted.
    fn learn(&mut self, part: Part, understood: Understood, origin: Origin) {
        self.use_up(&part);
        match (&part, understood) {
            (Part::Panoramas(district), Understood::Panoramas(panoramas)) => {
                self.survey.panoramas.insert(*district, panoramas);
            }
            (Part::Page(page), Understood::Page(entries)) => {
                if let Err(error) = self.survey.hierarchy.insert(*page, entries) {
                    self.loader.reject(&part, origin);
                    let error = StreamError::field("GetHierarchy")(error);
                    return self.trouble(&part, error, true);
                }
            }
            (Part::Stations(source), Understood::Stations(track)) => {
                self.survey.tracks.insert(*source, track);
            }
            (Part::Mask(name), Understood::Mask(mask)) => {
                self.survey.masks.insert(Arc::clone(name), mask);
            }
            _ => {}
        }
        self.plan.learn(part);
        self.learnt = true;
    }

    /// Chooses anew if more is known than before.
    fn catch_up(&mut self) {
        if std::mem::take(&mut self.learnt) {
            self.choose();
            self.unpark();
            self.report();
        }
    }

    fn unpark(&mut self) {
        for (part, payload, origin) in std::mem::take(&mut self.parked) {
            self.decode(part, payload, origin);
        }
    }

    /// A part could not be had, or not be used.
    fn trouble(&mut self, part: &Part, error: StreamError, single: bool) {
        if error.is_garbage() {
            let damages = self.damages.entry(part.clone()).or_default();
            *damages += 1;
            // Of several that were asked for together another may be at fault: each is asked for by
            // itself before it is given up.
            if *damages == 1 || !single {
                add(&self.counts.refetched, 1);
                let verdict = if single { Verdict::Again } else { Verdict::Alone };
                return self.plan.fail(part, verdict);
            }
        } else if error.is_transient() || matches!(error, StreamError::Cancelled) {
            let excuses = self.excuses.entry(part.clone()).or_default();
            *excuses += u32::from(single && error.is_excuse());
            if *excuses < MOST_EXCUSES {
                add(&self.counts.retries, 1);
                let together = !single && error.is_excuse();
                let verdict = if together { Verdict::Alone } else { Verdict::Again };
                self.plan.fail(part, verdict);
                if self.heard.elapsed() > PATIENCE {
                    self.heard = Instant::now();
                    self.fault(error);
                }
                return;
            }
        } else if !single {
            return self.plan.fail(part, Verdict::Alone);
        }
        self.plan.fail(part, Verdict::Never);
        self.fault(error);
        self.unpark();
        self.report();
    }

    /// What came of a part is used after all.
    fn use_up(&mut self, part: &Part) {
        if let Some(bytes) = self.unused.remove(part) {
            sub(&self.counts.unused, bytes);
        }
    }

    fn fault(&mut self, error: StreamError) {
        self.outbox.push_back(Event::Fault { view: self.view, error });
    }

    fn tell(&mut self, updates: Vec<SceneUpdate>) {
        updates.iter().for_each(|update| self.survey.surfaces.note(update));
        self.outbox.extend(updates.into_iter().map(Event::Update));
    }

    /// Says how far the view is; once all has come, what is to be dropped.
    fn report(&mut self) {
        if self.told {
            return;
        }
        let standing = self.plan.standing();
        if standing.complete_picture && !std::mem::replace(&mut self.sighted, true) {
            // The mesh is there, which shows what matters most.
            self.learnt = true;
        }
        if standing.finished {
            let drops = self.plan.drops();
            self.tell(drops);
            self.told = true;
        }
        let traffic = self.loader.client().traffic();
        if standing.complete_picture {
            self.complete_at.get_or_insert(traffic.bytes());
        }
        let progress = Event::Progress(Progress {
            view: self.view,
            bytes_received: traffic.bytes(),
            requests: traffic.requests(),
            remaining: standing.remaining,
            complete_picture: standing.complete_picture,
            complete_at: self.complete_at,
            finished: standing.finished,
        });
        // Where the last one was not told yet, it is out of date.
        if let Some(last @ Event::Progress(_)) = self.outbox.back_mut() {
            *last = progress;
        } else {
            self.outbox.push_back(progress);
        }
    }
}
