import { degrees, radians } from "../geometry/angles";
import { apply, transpose } from "../geometry/matrix";
import { subtract, type Vector3 } from "../geometry/vector";
import { camFromWorld, type Pose } from "./pose";

/** A pose and the size of its picture, in whatever pixels: (0, 0) is the top left corner. */
export interface Pinhole {
  readonly pose: Pose;
  readonly width: number;
  readonly height: number;
}

/** Focal length in pixels; they are square. */
export function focalLength(camera: Pinhole): number {
  return camera.height / 2 / Math.tan(radians(camera.pose.fovDeg) / 2);
}

/** What shows `height` pixels at that focal length. */
export function fovOf(focal: number, height: number): number {
  return 2 * degrees(Math.atan(height / 2 / focal));
}

/** Where a place is in the picture; undefined where it is not before the eye. */
export function project(camera: Pinhole, place: Vector3): [number, number] | undefined {
  const [x, y, z] = apply(camFromWorld(camera.pose), subtract(place, camera.pose.eye));
  // A millimetre before the eye all is over the border.
  if (z < 1e-3) {
    return undefined;
  }
  const focal = focalLength(camera);
  return [camera.width / 2 + (focal * x) / z, camera.height / 2 + (focal * y) / z];
}

/** Direction of a pixel in the world, of depth 1 along the axis. */
export function rayOf(camera: Pinhole, pixel: readonly [number, number]): Vector3 {
  const focal = focalLength(camera);
  return apply(transpose(camFromWorld(camera.pose)), [
    (pixel[0] - camera.width / 2) / focal,
    (pixel[1] - camera.height / 2) / focal,
    1,
  ]);
}
