import type { Clients } from "./api/clients";
import { reasonOf } from "./api/failure";
import { Session } from "./api/session";
import { Clicks } from "./clicks";
import { Keys } from "./controls/keys";
import { steerByPointers } from "./controls/pointers";
import type { ScreenPoint } from "./controls/steering";
import { element } from "./dom";
import type { Panorama } from "./gen/flaneur/v1/panorama_pb";
import type { Scene } from "./gen/flaneur/v1/scene_pb";
import { planDistance, type Vector3 } from "./geometry/vector";
import { Terrain } from "./ground/terrain";
import { Buildings } from "./map/buildings";
import { MapCorner } from "./map/corner";
import { Measuring } from "./measure/measuring";
import { referenceOf } from "./measure/reference";
import { Astray } from "./panels/astray";
import { copyText } from "./panels/copy";
import { helpDialog } from "./panels/help";
import { layerLegend, layerSwitches } from "./panels/layers";
import { sceneSwitch } from "./panels/scenes";
import { StatusPanel } from "./panels/status";
import { Toast } from "./panels/toast";
import { Toolbar, zoomButtons } from "./panels/toolbar";
import { Catalogue, placeOf } from "./photographs/catalogue";
import { PhotographDialog } from "./photographs/dialog";
import { Pace } from "./picture/pace";
import type { Screen } from "./picture/request";
import { Stage } from "./picture/stage";
import { positionOf } from "./place/pick";
import { LAYER_NAMES, type Layer } from "./state/layer";
import { EYE_HEIGHT_M, firstFovDeg, firstPose, isNear } from "./state/start";
import { atRest, type LinkState, writeLink } from "./state/url";
import { Value } from "./state/value";
import { TEXT } from "./strings";
import { lookingAt, type Pose } from "./view/pose";
import { Visit } from "./visit";

/** What surrounds one is fetched so far, metres. */
const SURROUNDINGS_M = 600;
/** Where that fails, it is tried again after so long, milliseconds. */
const PAUSE_MS = 5000;
/** The address follows once one has stood still for so long, milliseconds. */
const LINK_MS = 250;

/** Opens a scene in the page: everything there is, and what leads from one to the other. */
export async function openStreet(
  page: HTMLElement,
  clients: Clients,
  scenes: readonly Scene[],
  scene: Scene,
  link: LinkState,
): Promise<void> {
  document.title = TEXT.title(scene.name);
  const terrain = new Terrain(clients.ground, scene);
  const catalogue = new Catalogue(clients.panoramas, scene.name);
  const buildings = new Buildings(clients.footprints, scene.name);
  const linked = link.pose && isNear(scene, link.pose.eye) ? link.pose : undefined;
  const first = atRest(linked ?? (await withoutLink(scene, catalogue, buildings, terrain)));

  const pose = new Value<Pose>(first);
  const layer = new Value<Layer>(link.layer);
  const host = element("div", {
    class: "stage",
    tabindex: 0,
    role: "application",
    "aria-label": TEXT.stage,
  });
  page.replaceChildren(host);
  const stage = new Stage(host, first);
  const pace = new Pace();
  const toast = new Toast();
  const screen = (): Screen => ({
    width: Math.max(host.clientWidth, 1),
    height: Math.max(host.clientHeight, 1),
    density: window.devicePixelRatio || 1,
  });
  const still = () => matchMedia("(prefers-reduced-motion: reduce)").matches;
  const middle = (): ScreenPoint => [host.clientWidth / 2, host.clientHeight / 2];

  const status = new StatusPanel(() => session.hurry());
  const session = new Session(clients.render, scene.name, {
    async frame(frame) {
      pace.took(frame);
      await stage.add(frame);
      status.frame(frame);
      astray.frame(frame);
      host.dispatchEvent(new CustomEvent("flaneur:frame", { detail: frame }));
    },
    state(state) {
      status.session(state);
    },
    wanted(sequence) {
      host.dataset.sequence = String(sequence);
      status.wanted(sequence);
    },
  });

  const visit = new Visit({
    pose,
    layer,
    stage,
    session,
    terrain,
    buildings,
    pace,
    screen,
    still,
    keys: () => keys,
    act: (at) => {
      pulse(host, at);
      void clicks.once(at);
    },
    actTwice: (at) => void clicks.twice(at),
  });

  const stand = (panorama: Panorama) => visit.go({ ...pose.get(), eye: placeOf(panorama) });
  const photographs = new PhotographDialog(
    clients.panoramas,
    scene.name,
    catalogue,
    (eye, place) => {
      measuring.panel.fold();
      host.focus({ preventScroll: true });
      visit.go(lookingAt({ ...pose.get(), eye }, positionOf(place)));
    },
  );
  const measuring = new Measuring(stage, referenceOf(scene), {
    open: (sight, place) => void photographs.open(sight, place),
    changed: (on) => {
      toolbar.measuring = on;
      toolbar.mapShown = corner.isSeen;
      host.classList.toggle("measuring", on);
    },
  });
  const clicks = new Clicks({
    render: clients.render,
    scene: scene.name,
    session,
    pose,
    layer,
    screen,
    visit,
    terrain,
    catalogue,
    measuring,
    toast,
    stand,
  });

  const astray = new Astray(scene, async () => {
    try {
      visit.go(await withoutLink(scene, catalogue, buildings, terrain));
      host.focus({ preventScroll: true });
    } catch (error) {
      toast.say(TEXT.failed(reasonOf(error)));
    }
  });
  const help = helpDialog();
  const corner = new MapCorner(scene, pose, {
    go(x, y) {
      if (!buildings.contain(x, y)) {
        void visit.goTo(x, y, EYE_HEIGHT_M);
        return;
      }
      // There is nothing to be seen in there.
      const panorama = catalogue.nearest([x, y, 0]);
      if (panorama) {
        stand(panorama);
      }
      toast.say(panorama ? TEXT.beforeBuilding : TEXT.insideBuilding);
    },
    goToPhotograph(id) {
      const panorama = [...catalogue.all].find((panorama) => panorama.id === id);
      if (panorama) {
        stand(panorama);
      }
    },
    changed: () => {
      toolbar.mapShown = corner.isSeen;
    },
    leave: () => host.focus({ preventScroll: true }),
  });
  const toolbar = new Toolbar({
    measure: () => measuring.toggle(),
    map: () => {
      if (corner.isSeen || corner.root.hidden) {
        corner.toggle();
      }
      if (corner.root.hidden) {
        measuring.resume();
      } else if (!corner.isSeen) {
        measuring.putAside();
      }
    },
    link: () => void copyLink(toast),
    help: () => help.showModal(),
  });
  const zoom = (factor: number) => visit.zoom(factor, middle());
  const keys = new Keys(
    host,
    {
      act: () => void clicks.once(middle()),
      nearestPhotograph: () => void clicks.nearestPhotograph(),
      level: () => visit.go({ ...pose.get(), pitchDeg: 0 }),
      zoom,
      measure: () => measuring.toggle(),
      leave: () => measuring.close(),
      help: () => help.showModal(),
      layer(index) {
        const name = LAYER_NAMES[index];
        if (name) {
          layer.set(name);
        }
      },
    },
    () => visit.wake(),
  );
  steerByPointers(host, visit);

  page.append(
    element("h1", { class: "unseen" }, TEXT.title(scene.name)),
    status.progress,
    element(
      "div",
      { class: "top" },
      sceneSwitch(scenes, scene.name),
      layerSwitches(layer),
      toolbar.root,
    ),
    element(
      "div",
      { class: "lower" },
      measuring.panel.root,
      element(
        "div",
        { class: "bottom" },
        corner.root,
        layerLegend(layer),
        element("div", { class: "end" }, zoomButtons(zoom), status.root),
      ),
    ),
    astray.root,
    toast.root,
    help,
    photographs.root,
  );
  host.append(measuring.ruler.root, element("div", { class: "reticle", "aria-hidden": "true" }));

  followView(host, pose, stage, corner, measuring);
  followLink(scene.name, pose, layer);
  // A new picture for a new window; the old one fills it meanwhile.
  new ResizeObserver(() => {
    stage.show(pose.get());
    measuring.ruler.show(stage.shown);
    corner.follow(pose.get(), stage.shown);
    toolbar.mapShown = corner.isSeen;
    visit.again();
  }).observe(host);
  window.addEventListener("online", () => session.hurry());
  document.addEventListener("visibilitychange", () => {
    if (!document.hidden) {
      session.hurry();
    }
  });
  // Whoever chose a switch with the mouse goes on walking with the keys.
  page.addEventListener("click", (event) => {
    const { target, detail } = event;
    const tools = ".layers, .toolbar, .zoom, .inset-map";
    if (detail > 0 && target instanceof Element && target.closest(tools)) {
      host.focus({ preventScroll: true });
    }
  });
  host.focus({ preventScroll: true });

  if (link.misplaced || (link.pose && !linked)) {
    toast.say(TEXT.linkElsewhere);
  }
  keepSurroundings(pose, catalogue, buildings, corner);
  await terrain.around(first.eye[0], first.eye[1]);
}

async function withoutLink(
  scene: Scene,
  catalogue: Catalogue,
  buildings: Buildings,
  terrain: Terrain,
): Promise<Pose> {
  const { x = 0, y = 0, z = 0 } = scene.origin ?? {};
  const centre: Vector3 = [x, y, z];
  if (scene.panoramaCount === 0n) {
    await buildings.fetch(centre, SURROUNDINGS_M);
  } else {
    await catalogue.fetch({ centre, radiusM: SURROUNDINGS_M });
    if (!catalogue.nearest(centre)) {
      await catalogue.fetch();
    }
  }
  const fov = firstFovDeg(window.innerWidth, window.innerHeight);
  return firstPose(scene, catalogue, buildings, terrain, fov);
}

/** What follows the view at each step. */
function followView(
  host: HTMLElement,
  pose: Value<Pose>,
  stage: Stage,
  corner: MapCorner,
  measuring: Measuring,
): void {
  stage.onShown(() => {
    measuring.ruler.show(stage.shown);
    host.dispatchEvent(new CustomEvent("flaneur:shown", { detail: stage.shown }));
  });
  pose.watch((pose) => corner.follow(pose, stage.shown));
}

/** The address is that of the view. */
function followLink(scene: string, pose: Value<Pose>, layer: Value<Layer>): void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  const write = () => {
    clearTimeout(timer);
    timer = setTimeout(() => {
      const link = writeLink(scene, pose.get(), layer.get());
      history.replaceState(null, "", link);
    }, LINK_MS);
  };
  pose.watch(write);
  layer.watch(write);
}

async function copyLink(toast: Toast): Promise<void> {
  if (await copyText(location.href)) {
    toast.say(TEXT.linkCopied);
  }
}

/** The map, and double clicks, know what is around, wherever one goes. */
function keepSurroundings(
  pose: Value<Pose>,
  catalogue: Catalogue,
  buildings: Buildings,
  corner: MapCorner,
): void {
  let centre: Vector3 | undefined;
  pose.watch(({ eye }) => {
    if (centre && planDistance(centre, eye) < SURROUNDINGS_M / 2) {
      return;
    }
    centre = eye;
    const fetched = [
      catalogue.fetch({ centre: eye, radiusM: SURROUNDINGS_M }),
      buildings.fetch(eye, SURROUNDINGS_M),
    ];
    void Promise.allSettled(fetched).then((outcomes) => {
      corner.draw(buildings, catalogue);
      if (outcomes.some(({ status }) => status === "rejected")) {
        // A later step tries again.
        setTimeout(() => {
          centre = undefined;
        }, PAUSE_MS);
      }
    });
  });
}

/** Says that a click was felt, before the server says what was met. */
function pulse(host: HTMLElement, at: ScreenPoint): void {
  const ring = element("span", { class: "pulse", "aria-hidden": "true" });
  ring.style.left = `${at[0]}px`;
  ring.style.top = `${at[1]}px`;
  ring.addEventListener("animationend", () => ring.remove());
  host.append(ring);
}
