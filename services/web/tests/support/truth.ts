import fs from "node:fs";
import path from "node:path";
import { add, length, scale, subtract, type Vector3 } from "../../src/geometry/vector";
import { rayOf } from "../../src/view/pinhole";
import type { Pose } from "../../src/view/pose";
import { readNpy } from "./npy";
import { STREET } from "./place";

interface StoredView {
  readonly position: Vector3;
  readonly heading_deg: number;
  readonly pitch_deg: number;
  readonly fov_deg: number;
  readonly width: number;
  readonly height: number;
  readonly depth: string;
}

export interface Surface {
  readonly place: Vector3;
  /** Upwards, from -1 to 1: the ground has 1, a wall 0. */
  readonly up: number;
}

/** A view of the synthetic street of which every pixel's place is known exactly. */
export interface TrueView {
  readonly pose: Pose;
  readonly width: number;
  readonly height: number;
  /** The surface at the centre of a pixel; undefined where it is not flat. */
  flat(column: number, row: number): Surface | undefined;
}

export function trueViews(): TrueView[] {
  const folder = path.join(STREET, "truth");
  const views = JSON.parse(fs.readFileSync(path.join(folder, "views.json"), "utf8"));
  return (views as StoredView[]).map((view) => trueView(view, path.join(folder, view.depth)));
}

function trueView(view: StoredView, depthFile: string): TrueView {
  const { width, height } = view;
  const pose: Pose = {
    eye: view.position,
    headingDeg: view.heading_deg,
    pitchDeg: view.pitch_deg,
    fovDeg: view.fov_deg,
  };
  const depth = readNpy(depthFile);
  const at = (column: number, row: number) =>
    depth.values[row * depth.columns + column] ?? Number.NaN;
  return {
    pose,
    width,
    height,
    flat(column, row) {
      const z = at(column, row);
      // On a plane the inverse depth is linear in the picture.
      const bent = (dx: number, dy: number) =>
        Math.abs(1 / at(column - dx, row - dy) + 1 / at(column + dx, row + dy) - 2 / z) * z;
      const reach = 6;
      const worst = Math.max(bent(reach, 0), bent(0, reach), bent(reach, reach), bent(2, 2));
      if (!Number.isFinite(z) || !(worst < 1e-3)) {
        return undefined;
      }
      const place = (dx: number, dy: number): Vector3 => {
        const ray = rayOf({ pose, width, height }, [column + dx + 0.5, row + dy + 0.5]);
        return add(pose.eye, scale(ray, at(column + dx, row + dy)));
      };
      const right = subtract(place(reach, 0), place(-reach, 0));
      const down = subtract(place(0, reach), place(0, -reach));
      const normal: Vector3 = [
        down[1] * right[2] - down[2] * right[1],
        down[2] * right[0] - down[0] * right[2],
        down[0] * right[1] - down[1] * right[0],
      ];
      return { place: place(0, 0), up: normal[2] / length(normal) };
    },
  };
}
