import type { ScreenPoint } from "../../src/controls/steering";
import type { Vector3 } from "../../src/geometry/vector";
import { writeLink } from "../../src/state/url";
import type { Pose } from "../../src/view/pose";
import type { TrueView } from "./truth";

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
  fits: (place: Vector3, view: TrueView) => boolean,
): TruePlace[] {
  const found: TruePlace[] = [];
  for (const view of views) {
    // Beneath the panels at the borders nothing can be clicked.
    for (let row = 90; row < view.height - 190; row += 24) {
      for (let column = 90; column < view.width - 90; column += 24) {
        const place = view.flatPlace(column, row);
        if (place && fits(place, view)) {
          const at: ScreenPoint = [
            ((column + 0.5) * WIDTH) / view.width,
            ((row + 0.5) * HEIGHT) / view.height,
          ];
          found.push({ view, place, at });
        }
      }
    }
  }
  return found;
}

/** The first of them. */
export function findPixel(
  views: readonly TrueView[],
  fits: (place: Vector3, view: TrueView) => boolean,
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
