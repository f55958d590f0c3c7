import { element } from "../dom";
import type { Scene } from "../gen/flaneur/v1/scene_pb";
import { degrees } from "../geometry/angles";
import { tool } from "../panels/toolbar";
import { type Catalogue, placeOf } from "../photographs/catalogue";
import type { Value } from "../state/value";
import { TEXT } from "../strings";
import { focalLength, type Pinhole } from "../view/pinhole";
import type { Pose } from "../view/pose";
import type { Buildings } from "./buildings";
import { DrawnMap } from "./drawn_map";
import { earthOf } from "./earth";
import { type InsetMap, type InsetMapEvents, NEAR_PX, nearestSpot, type Spot } from "./inset";
import { MapKeys } from "./steering";

/** On narrower screens the map waits until it is asked for, CSS pixels. */
const NARROW_PX = 640;

export interface MapCornerEvents extends InsetMapEvents {
  /** Shown or hidden. */
  changed(): void;
  /** The keys are the street's again. */
  leave(): void;
}

/** The place of the inset map; the map itself comes once it is shown for the first time. */
export class MapCorner {
  readonly root: HTMLElement;
  readonly #scene: Scene;
  readonly #pose: Value<Pose>;
  readonly #events: MapCornerEvents;
  /** What can be focused, and holds the map. */
  readonly #surface: HTMLElement;
  readonly #keys: MapKeys;
  #spots: readonly Spot[] = [];
  #map: InsetMap | undefined;
  #opened = false;
  #data: { buildings: Buildings; catalogue: Catalogue } | undefined;
  #widthDeg = 90;

  constructor(scene: Scene, pose: Value<Pose>, events: MapCornerEvents) {
    this.#scene = scene;
    this.#pose = pose;
    this.#events = events;
    this.#surface = element("div", {
      class: "surface",
      tabindex: 0,
      role: "application",
      "aria-label": TEXT.insetMap,
    });
    this.#keys = new MapKeys(this.#surface, {
      map: () => this.#map,
      eye: () => pose.get().eye,
      go: () => this.#goToMiddle(),
      photograph: () => this.#inMiddle()?.panorama,
      leave: events.leave,
    });
    this.root = element(
      "section",
      { class: "inset-map floating", "aria-label": TEXT.map, hidden: true },
      this.#surface,
      element("div", { class: "cross", "aria-hidden": "true" }),
      element(
        "div",
        { class: "map-zoom" },
        tool("plus", TEXT.mapZoomIn, () => this.#keys.nearer()),
        tool("minus", TEXT.mapZoomOut, () => this.#keys.farther()),
      ),
      this.#keys.words,
    );
    // After the page is put together, and after the street was asked for.
    setTimeout(() => {
      if (window.innerWidth >= NARROW_PX) {
        this.toggle();
      }
    }, 200);
  }

  /** Whether it is on the screen: on a small one a panel may take its place. */
  get isSeen(): boolean {
    return this.root.getClientRects().length > 0;
  }

  toggle(): void {
    this.root.hidden = !this.root.hidden;
    this.#events.changed();
    if (!this.root.hidden) {
      void this.#open();
      this.#map?.resized();
    }
  }

  draw(buildings: Buildings, catalogue: Catalogue): void {
    this.#data = { buildings, catalogue };
    this.#fill();
  }

  follow(pose: Pose, shown: Pinhole): void {
    const half = shown.width / 2 / focalLength({ ...shown, pose });
    this.#widthDeg = 2 * degrees(Math.atan(half));
    if (!this.root.hidden) {
      this.#map?.follow(pose, this.#widthDeg);
    }
  }

  async #open(): Promise<void> {
    if (this.#opened) {
      return;
    }
    this.#opened = true;
    const pose = this.#pose.get();
    try {
      const { WebGlMap } = await import("./webgl_map");
      this.#map = new WebGlMap(this.#surface, earthOf(this.#scene), pose, this.#events);
    } catch {
      this.#map = new DrawnMap(this.#surface, pose, this.#events);
    }
    this.#fill();
    this.#map.follow(this.#pose.get(), this.#widthDeg);
  }

  #fill(): void {
    if (this.#data) {
      this.#spots = [...this.#data.catalogue.all].map((panorama) => ({
        panorama: panorama.id,
        place: placeOf(panorama),
      }));
      this.#map?.draw(this.#data.buildings.all, this.#spots);
    }
  }

  #inMiddle(): Spot | undefined {
    const map = this.#map;
    return map && nearestSpot(this.#spots, ...map.centre, NEAR_PX * map.metresPerPixel);
  }

  #goToMiddle(): void {
    const spot = this.#inMiddle();
    if (spot) {
      this.#events.goToPhotograph(spot.panorama);
    } else if (this.#map) {
      this.#events.go(...this.#map.centre);
    }
  }
}
