import { element, svg } from "../dom";
import { clamp } from "../geometry/angles";
import { TEXT } from "../strings";
import type { Pose } from "../view/pose";
import type { Outline } from "./buildings";
import {
  conePath,
  type InsetMap,
  type InsetMapEvents,
  NEAR_PX,
  nearestSpot,
  type Spot,
} from "./inset";

/** What the map shows from side to side, metres. */
const FIRST_WIDTH_M = 140;
const NARROWEST_M = 20;
const WIDEST_M = 4000;
/** The box's own units, about pixels. */
const SIZE = 240;

/** A plain map for browsers without WebGL: grid north is up, and whoever walks is in its middle. */
export class DrawnMap implements InsetMap {
  readonly root: HTMLElement;
  readonly #scene = svg("g");
  readonly #shapes = svg("path", { class: "buildings", "fill-rule": "evenodd" });
  readonly #spots = svg("g", { class: "spots" });
  readonly #cone = svg("path", { class: "cone" });
  readonly #here = svg("g", { class: "here" });
  #origin: readonly [number, number];
  #pose: Pose;
  #centre: readonly [number, number];
  #widthM = FIRST_WIDTH_M;
  #places: readonly Spot[] = [];

  constructor(box: HTMLElement, pose: Pose, events: InsetMapEvents) {
    this.#pose = pose;
    this.#origin = [pose.eye[0], pose.eye[1]];
    this.#centre = this.#origin;
    this.#here.append(this.#cone, svg("circle", { r: 6 }));
    this.#scene.append(this.#shapes, this.#spots);
    const half = SIZE / 2;
    const drawing = svg(
      "svg",
      {
        viewBox: `${-half} ${-half} ${SIZE} ${SIZE}`,
        preserveAspectRatio: "xMidYMid slice",
        "aria-hidden": "true",
      },
      this.#scene,
      this.#here,
    );
    this.root = element("div", { class: "canvas drawn", title: TEXT.mapPlain });
    this.root.append(drawing);
    box.append(this.root);
    drawing.addEventListener("click", (event) => {
      const matrix = drawing.getScreenCTM();
      if (!matrix) {
        return;
      }
      const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix.inverse());
      const metres = this.metresPerPixel;
      const [x, y] = [this.#centre[0] + at.x * metres, this.#centre[1] - at.y * metres];
      const near = nearestSpot(this.#places, x, y, NEAR_PX * metres);
      if (near) {
        events.goToPhotograph(near.panorama);
      } else {
        events.go(x, y);
      }
    });
    drawing.addEventListener(
      "wheel",
      (event) => {
        event.preventDefault();
        this.zoom(Math.exp(-clamp(event.deltaY, -300, 300) * 0.002));
      },
      { passive: false },
    );
  }

  draw(buildings: Iterable<readonly Outline[]>, spots: readonly Spot[]): void {
    // Relative to where the visit began: single precision would jitter far from zero.
    const [x0, y0] = this.#origin;
    const at = ([x, y]: readonly [number, number]) =>
      `${(x - x0).toFixed(2)} ${(y0 - y).toFixed(2)}`;
    let path = "";
    for (const outlines of buildings) {
      for (const ring of outlines.flat()) {
        path += `M${ring.map(at).join("L")}Z`;
      }
    }
    this.#shapes.setAttribute("d", path);
    this.#places = spots;
    this.#spots.replaceChildren(
      ...spots.map(({ place: [x, y] }) => svg("circle", { cx: x - x0, cy: y0 - y, r: 0.8 })),
    );
    this.#place();
  }

  get centre(): readonly [number, number] {
    return this.#centre;
  }

  get metresPerPixel(): number {
    return this.#widthM / SIZE;
  }

  pan(right: number, down: number): void {
    const [x, y] = this.#centre;
    this.#centre = [x + right * this.metresPerPixel, y - down * this.metresPerPixel];
    this.#place();
  }

  zoom(factor: number): void {
    this.#widthM = clamp(this.#widthM / factor, NARROWEST_M, WIDEST_M);
    this.#place();
  }

  follow(pose: Pose, widthDeg: number): void {
    const [x, y] = pose.eye;
    if (this.#pose.eye[0] !== x || this.#pose.eye[1] !== y) {
      this.#centre = [x, y];
    }
    this.#pose = pose;
    this.#cone.setAttribute("d", conePath(widthDeg));
    this.#place();
  }

  resized(): void {
    // A drawing scales by itself.
  }

  #place(): void {
    const scale = SIZE / this.#widthM;
    const [x, y] = this.#centre;
    const [dx, dy] = [this.#origin[0] - x, y - this.#origin[1]];
    this.#scene.setAttribute("transform", `scale(${scale}) translate(${dx} ${dy})`);
    const [u, v] = [scale * (this.#pose.eye[0] - x), scale * (y - this.#pose.eye[1])];
    const turned = `translate(${u} ${v}) rotate(${this.#pose.headingDeg})`;
    this.#here.setAttribute("transform", turned);
  }
}
