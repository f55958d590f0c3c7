import type { ScreenPoint } from "../../src/controls/steering";
import type { Vector3 } from "../../src/geometry/vector";
import { writeLink } from "../../src/state/url";
import type { Pose } from "../../src/view/pose";
import type { Surface, TrueView } from "./truth";

/** The page of the tests, CSS pixels: of the shape of the true views. */
export const WIDTH = 1024;
export const HEIGHT = 768;

export interface TruePlace {
  readonly view: TrueView;
  readonly place: Vector3;
  /** Where the place is on the page. */
  readonly at: ScreenPoint;
}

/** Every place of a coarse grid over the views whose surface is flat, and that fits. */
export function findPixels(
  views: readonly TrueView[],
  fits: (surface: Surface, view: TrueView) => boolean,
): TruePlace[] {
  const found: TruePlace[] = [];
  for (const view of views) {
    for (let row = 90; row < view.height - 40; row += 24) {
      // Beneath the panels in the corners nothing can be clicked.
      const border = row < view.height - 190 ? 90 : 230;
      for (let column = border; column < view.width - border; column += 24) {
        const surface = view.flat(column, row);
        if (surface && fits(surface, view)) {
          const at: ScreenPoint = [
            ((column + 0.5) * WIDTH) / view.width,
            ((row + 0.5) * HEIGHT) / view.height,
          ];
          found.push({ view, place: surface.place, at });
        }
      }
    }
  }
  return found;
}

/** The first of them. */
export function findPixel(
  views: readonly TrueView[],
  fits: (surface: Surface, view: TrueView) => boolean,
): TruePlace {
  const [first] = findPixels(views, fits);
  if (!first) {
    throw new Error("no view shows such a place");
  }
  return first;
}

export function linkTo(server: string, pose: Pose): string {
  return server + writeLink("sample", pose, "hybrid");
}
