import type { ScreenPoint } from "../controls/steering";
import { element } from "../dom";
import { MeshSurface_Class, type Place, type Sight } from "../gen/flaneur/v1/render_pb";
import { icon } from "../icons";
import { copyText } from "../panels/copy";
import { positionOf } from "../place/pick";
import { TEXT } from "../strings";
import { momentOf } from "./gps_time";
import { lasClass } from "./las_class";
import {
  coordinates,
  geographic,
  measure,
  metres,
  type Pointed,
  plusMinus,
  roughMetres,
  signedMetres,
} from "./measurement";
import { sideFor } from "./side";

/** So long a button says that it has copied, milliseconds. */
const COPIED_MS = 2000;

/** What the panel leads to. */
export interface MeasurePanelEvents {
  close(): void;
  clear(): void;
  open(sight: Sight, place: Place): void;
}

/** Says where the measured places are, from what they are known, and what lies between them. */
export class MeasurePanel {
  readonly #reference: string;
  readonly #events: MeasurePanelEvents;
  readonly #body: HTMLElement;
  /** All that there is room for on a narrow screen, unless it is opened; and what is read aloud. */
  readonly #line = element("p", { class: "line", role: "status" });
  readonly #handle = element("button", {
    type: "button",
    class: "plain handle",
    "aria-label": TEXT.measureDetails,
    "aria-expanded": "false",
    "aria-controls": "measured",
  });
  readonly root: HTMLElement;

  /** `reference` says what coordinates refer to. */
  constructor(reference: string, events: MeasurePanelEvents) {
    this.#reference = reference;
    this.#events = events;
    this.#body = element("div", { class: "body", id: "measured" });
    this.#handle.append(icon("open"));
    this.#handle.addEventListener("click", () => {
      this.#unfold(!this.root.classList.contains("open"));
    });
    const close = element("button", { type: "button", class: "plain", "aria-label": TEXT.close });
    close.append(icon("close"));
    close.addEventListener("click", () => events.close());
    const head = element(
      "header",
      {},
      element("h2", {}, TEXT.measurePanel),
      this.#line,
      this.#handle,
      close,
    );
    this.root = element(
      "section",
      { class: "panel measure-panel", "aria-label": TEXT.measurePanel, hidden: true },
      head,
      this.#body,
    );
    this.show([], false);
  }

  /** The places so far, and whether another is being asked for. */
  show(places: readonly Pointed[], asking: boolean): void {
    const [from, to] = places;
    const parts: HTMLElement[] = [];
    if (from && to) {
      parts.push(distanceOf(from, to));
    }
    places.forEach(({ place }, index) => {
      parts.push(this.#placeOf(place, index === 0 ? "A" : "B", places.length > 1));
    });
    if (asking) {
      parts.push(element("p", { class: "hint" }, TEXT.measuring));
    } else if (places.length === 0) {
      parts.push(element("p", { class: "hint" }, TEXT.measureHint));
    }
    if (places.length > 0) {
      const clear = element("button", { type: "button", class: "text" }, TEXT.clear);
      clear.addEventListener("click", () => this.#events.clear());
      parts.push(clear);
    }
    this.#body.replaceChildren(...parts);
    this.#line.textContent = asking ? TEXT.measuring : lineOf(from, to);
  }

  /** Where it is a line, it is no more than that. */
  fold(): void {
    this.#unfold(false);
  }

  /** Goes out of the way of places on the page. */
  spare(places: readonly ScreenPoint[]): void {
    const now = this.root.classList.contains("left") ? "left" : "right";
    const side = sideFor(this.root.getBoundingClientRect(), window.innerWidth, places, now);
    this.root.classList.toggle("left", side === "left");
  }

  #unfold(open: boolean): void {
    this.root.classList.toggle("open", open);
    this.#handle.ariaExpanded = String(open);
  }

  #placeOf(place: Place, letter: string, lettered: boolean): HTMLElement {
    const rows = element("dl");
    const row = (name: string, ...values: (Node | string)[]) => {
      rows.append(element("dt", {}, name), element("dd", {}, ...values));
    };
    const { uncertaintyM } = place;
    const position = coordinates(positionOf(place), uncertaintyM);
    row(
      TEXT.position,
      element("span", { class: "figures", "data-figure": "position" }, position),
      copy(position, TEXT.copyPosition),
      remark(this.#reference),
    );
    if (place.geographic) {
      // Its height is that of the survey, not of the ellipsoid.
      const { latitudeDeg, longitudeDeg } = place.geographic;
      const text = geographic(latitudeDeg, longitudeDeg, uncertaintyM);
      row(
        TEXT.geographic,
        element("span", { class: "figures" }, text),
        copy(text, TEXT.copyGeographic),
        remark(TEXT.geographicAxes),
      );
    } else {
      row(TEXT.geographic, TEXT.notGeographic);
    }
    for (const [name, ...values] of surfaceOf(place)) {
      row(name, ...values);
    }
    row(TEXT.uncertainty, uncertaintyM > 0 ? plusMinus(uncertaintyM) : TEXT.unknownUncertainty);
    const [first] = place.photographs;
    row(
      TEXT.coloured,
      first ? `${first.panorama}/${first.camera}, ${dateOf(first.time)}` : TEXT.uncoloured,
    );
    const block = element("div", { class: "place" });
    if (lettered) {
      block.append(element("h3", {}, TEXT.place(letter)));
    }
    block.append(rows);
    if (place.photographs.length > 0) {
      block.append(this.#sightsOf(place));
    }
    return block;
  }

  #sightsOf(place: Place): HTMLElement {
    const list = element("ul", { class: "sights" });
    for (const sight of place.photographs) {
      const open = element(
        "button",
        { type: "button", class: "sight" },
        element("span", {}, `${sight.panorama}/${sight.camera}`),
        element(
          "span",
          { class: "aside" },
          `${dateOf(sight.time)} · ${roughMetres(sight.distanceM)}`,
        ),
      );
      open.addEventListener("click", () => this.#events.open(sight, place));
      list.append(element("li", {}, open));
    }
    const count = TEXT.photographs(place.photographs.length);
    const details = element("details", {}, element("summary", {}, count), list);
    // What was asked for is seen.
    details.addEventListener("toggle", () => {
      if (details.open) {
        details.scrollIntoView({ block: "nearest" });
      }
    });
    return details;
  }
}

/** The least that there is to say. */
function lineOf(from: Pointed | undefined, to: Pointed | undefined): string {
  if (!from) {
    return TEXT.measureHint;
  }
  if (!to) {
    return coordinates(positionOf(from.place), from.place.uncertaintyM);
  }
  const { distance, uncertainty } = measure(from, to);
  const sure = uncertainty === undefined ? "" : ` ${plusMinus(uncertainty)}`;
  return metres(distance, uncertainty) + sure;
}

function distanceOf(from: Pointed, to: Pointed): HTMLElement {
  const { distance, horizontal, vertical, uncertainty } = measure(from, to);
  const sure = uncertainty === undefined ? "" : ` ${plusMinus(uncertainty)}`;
  const main = element(
    "p",
    { class: "result", "aria-label": TEXT.distance },
    element("strong", { "data-figure": "distance" }, metres(distance, uncertainty)),
    element("span", { class: "aside" }, sure),
  );
  const parts = [
    `${TEXT.horizontal} ${metres(horizontal, uncertainty)}`,
    `${TEXT.vertical} ${signedMetres(vertical, uncertainty)}`,
  ].join(" · ");
  return element("div", {}, main, element("p", { class: "aside" }, parts));
}

/** From what the place is known. */
function surfaceOf(place: Place): [string, ...(Node | string)[]][] {
  const { surface } = place;
  if (surface.case === "point") {
    const { source, classification, position } = surface.value;
    const rows: [string, ...(Node | string)[]][] = [
      [TEXT.surface, TEXT.lidarPoint(source), remark(lasClass(classification))],
    ];
    if (position) {
      const exact = coordinates([position.x, position.y, position.z]);
      rows.push([TEXT.lidarExact, element("span", { class: "figures" }, exact)]);
    }
    const moment = momentOf(surface.value);
    const figure = { class: "figures", "data-figure": "moment" };
    rows.push([TEXT.gpsTime, element("span", figure, moment.time), remark(moment.remark)]);
    return rows;
  }
  if (surface.case === "mesh") {
    const { footprint } = surface.value;
    switch (surface.value.class) {
      case MeshSurface_Class.WALL:
        return [[TEXT.surface, TEXT.wall(footprint)]];
      case MeshSurface_Class.ROOF:
        return [[TEXT.surface, TEXT.roof(footprint)]];
      default:
        return [[TEXT.surface, TEXT.ground]];
    }
  }
  return [];
}

/** The day and minute of an RFC 3339 time, as they stand there, and its zone. */
export function dateOf(time: string): string {
  if (!time) {
    return TEXT.undated;
  }
  const zone = /[+-]\d\d:\d\d$/.exec(time)?.[0] ?? "UTC";
  return `${time.slice(0, 16).replace("T", " ")} ${zone.replace(/^[+-]00:00$/, "UTC")}`;
}

/** A button that copies a text; `name` says which. */
function copy(text: string, name: string): HTMLElement {
  const label = { "aria-label": name, title: name };
  const button = element("button", { type: "button", class: "text copy", ...label });
  button.append(icon("copy"));
  let timer: ReturnType<typeof setTimeout> | undefined;
  button.addEventListener("click", async () => {
    if (await copyText(text)) {
      button.replaceChildren(icon("done"));
      button.ariaLabel = TEXT.copied;
      clearTimeout(timer);
      timer = setTimeout(() => {
        button.replaceChildren(icon("copy"));
        button.ariaLabel = name;
      }, COPIED_MS);
    }
  });
  return button;
}

/** What is said of a figure, below it. */
function remark(text: string): HTMLElement {
  return element("div", { class: "aside" }, text);
}
