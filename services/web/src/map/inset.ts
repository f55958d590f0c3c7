import type { Vector3 } from "../geometry/vector";
import type { Pose } from "../view/pose";
import type { Outline } from "./buildings";

/** A photograph's place on the map. */
export interface Spot {
  readonly panorama: string;
  readonly place: Vector3;
}

/** The map in the corner: where one is, and what is around. */
export interface InsetMap {
  readonly root: HTMLElement;
  /** What is drawn. */
  draw(buildings: Iterable<readonly Outline[]>, spots: readonly Spot[]): void;
  /** Where one is and looks, and how wide one sees from side to side, degrees. */
  follow(pose: Pose, widthDeg: number): void;
  /** What is in its middle, in plan. */
  readonly centre: readonly [number, number];
  /** Metres that a pixel of it is wide, about. */
  readonly metresPerPixel: number;
  /** Shows what is so many pixels to the right and below. */
  pan(right: number, down: number): void;
  /** Shows so much less, > 1, or more, < 1. */
  zoom(factor: number): void;
  /** After its box has changed. */
  resized(): void;
}

/** A click, or the map's middle, is meant for a photograph that is so near, pixels. */
export const NEAR_PX = 8;

/** The photograph that is nearest to a place in plan, not farther than so many metres. */
export function nearestSpot(
  spots: readonly Spot[],
  x: number,
  y: number,
  withinM: number,
): Spot | undefined {
  let best: { spot: Spot; metres: number } | undefined;
  for (const spot of spots) {
    const metres = Math.hypot(spot.place[0] - x, spot.place[1] - y);
    if (metres <= withinM && (!best || metres < best.metres)) {
      best = { spot, metres };
    }
  }
  return best?.spot;
}

/** What a click on the map does. */
export interface InsetMapEvents {
  /** To a place in plan. */
  go(x: number, y: number): void;
  /** To a photograph. */
  goToPhotograph(panorama: string): void;
}

/** How far the view cone reaches on the map, pixels. */
export const CONE_PX = 46;

/** The cone of a view that looks up on the screen from (0, 0), as the path of an SVG. */
export function conePath(widthDeg: number): string {
  const half = (Math.min(widthDeg, 170) / 2) * (Math.PI / 180);
  const [x, y] = [CONE_PX * Math.sin(half), CONE_PX * Math.cos(half)];
  const at = (u: number, v: number) => `${u.toFixed(1)} ${v.toFixed(1)}`;
  return `M0 0L${at(-x, -y)}A${CONE_PX} ${CONE_PX} 0 0 1 ${at(x, -y)}Z`;
}
