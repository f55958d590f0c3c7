import { svg } from "../dom";
import type { Vector3 } from "../geometry/vector";
import { type Pinhole, project } from "../view/pinhole";

/** Marks of the measured places on the street, and a line between two of them. */
export class Ruler {
  readonly #root: SVGSVGElement;
  #places: readonly Vector3[] = [];
  #label = "";

  constructor() {
    this.#root = svg("svg", { class: "ruler", "aria-hidden": "true" });
  }

  get root(): SVGSVGElement {
    return this.#root;
  }

  /** At most two places, and what the line says. */
  set(places: readonly Vector3[], label: string, shown: Pinhole): void {
    this.#places = places;
    this.#label = label;
    this.show(shown);
  }

  /** Draws the marks where they are now. */
  show(shown: Pinhole): void {
    if (this.#places.length === 0 && this.#root.childElementCount === 0) {
      return;
    }
    const at = this.#places.map((place) => project(shown, place));
    const marks: SVGElement[] = [];
    const [a, b] = at;
    if (a && b) {
      const [x1, y1, x2, y2] = [...a, ...b].map((value) => value.toFixed(1));
      const [x, y] = [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
      marks.push(
        svg("line", { class: "casing", x1, y1, x2, y2 }),
        svg("line", { x1, y1, x2, y2 }),
        svg("text", { x: x.toFixed(1), y: (y - 10).toFixed(1) }, this.#label),
      );
    }
    at.forEach((place, index) => {
      if (place) {
        const [cx, cy] = place.map((value) => value.toFixed(1));
        const letter = index === 0 ? "A" : "B";
        marks.push(
          svg("circle", { class: "casing", cx, cy, r: 6 }),
          svg("circle", { cx, cy, r: 6 }),
          svg(
            "text",
            { x: (place[0] + 11).toFixed(1), y: (place[1] + 4).toFixed(1), class: "letter" },
            letter,
          ),
        );
      }
    });
    this.#root.replaceChildren(...marks);
  }
}
