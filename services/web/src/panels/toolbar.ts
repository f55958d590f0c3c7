import { element } from "../dom";
import { type Icon, icon } from "../icons";
import { TEXT } from "../strings";

export interface ToolbarEvents {
  measure(): void;
  map(): void;
  link(): void;
  help(): void;
}

/** The tools, and which of them are on. */
export class Toolbar {
  readonly root: HTMLElement;
  readonly #measure: HTMLButtonElement;
  readonly #map: HTMLButtonElement;

  constructor(events: ToolbarEvents) {
    this.#measure = tool("measure", TEXT.measure, events.measure);
    this.#map = tool("map", TEXT.map, events.map);
    this.root = element(
      "div",
      { class: "toolbar floating", role: "toolbar", "aria-label": TEXT.toolbar },
      this.#measure,
      this.#map,
      tool("link", TEXT.copyLink, events.link),
      tool("help", TEXT.help, events.help),
    );
    this.measuring = false;
    this.mapShown = false;
  }

  set measuring(on: boolean) {
    this.#measure.setAttribute("aria-pressed", String(on));
  }

  set mapShown(on: boolean) {
    this.#map.setAttribute("aria-pressed", String(on));
  }
}

/** Narrows and widens the view. */
export function zoomButtons(zoom: (factor: number) => void): HTMLElement {
  const nearer = tool("plus", TEXT.zoomIn, () => zoom(1.3));
  const farther = tool("minus", TEXT.zoomOut, () => zoom(1 / 1.3));
  return element("div", { class: "zoom floating" }, nearer, farther);
}

/** A button with an icon. */
export function tool(name: Icon, label: string, act: () => void): HTMLButtonElement {
  const button = element("button", { type: "button", "aria-label": label, title: label });
  button.append(icon(name));
  button.addEventListener("click", act);
  return button;
}
