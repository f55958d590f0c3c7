import { apply, type Matrix3, multiply, transpose } from "../geometry/matrix";
import { dot, subtract, type Vector3 } from "../geometry/vector";
import { focalLength, type Pinhole } from "./pinhole";
import { camFromWorld } from "./pose";

/**
 * Pixels of `to` from pixels of `from`, up to scale: H = K' (R + t nᵀ / d) K⁻¹, with R and t those
 * of cam_to_from_cam_from, for what lies on the plane nᵀ p = d of `from`'s camera.
 *
 * With one eye t is zero, and this is exact for all there is. Where the eye has gone on, all is
 * taken to stand upright before it, `distance` metres away: a guess that grows what one walks
 * towards.
 */
export function homography(to: Pinhole, from: Pinhole, distance: number): Matrix3 {
  const toFromWorld = camFromWorld(to.pose);
  const worldFromFrom = transpose(camFromWorld(from.pose));
  const rotation = multiply(toFromWorld, worldFromFrom);
  const step = subtract(from.pose.eye, to.pose.eye);
  const t = apply(toFromWorld, step);
  // The horizontal direction in which `from` looks, in its camera's frame.
  const heading = from.pose.headingDeg * (Math.PI / 180);
  const n = apply(camFromWorld(from.pose), [Math.sin(heading), Math.cos(heading), 0]);
  const plane = n.map((value) => value / distance) as unknown as Vector3;
  const row = (r: 0 | 1 | 2): Vector3 => [
    rotation[r][0] + t[r] * plane[0],
    rotation[r][1] + t[r] * plane[1],
    rotation[r][2] + t[r] * plane[2],
  ];
  const [f, g] = [focalLength(from), focalLength(to)];
  const toPixels: Matrix3 = [
    [g, 0, to.width / 2],
    [0, g, to.height / 2],
    [0, 0, 1],
  ];
  const fromRays: Matrix3 = [
    [1 / f, 0, -from.width / 2 / f],
    [0, 1 / f, -from.height / 2 / f],
    [0, 0, 1],
  ];
  return multiply(multiply(toPixels, [row(0), row(1), row(2)]), fromRays);
}

/** Where a pixel goes; undefined where that is behind the eye. */
export function mapped(h: Matrix3, pixel: readonly [number, number]): [number, number] | undefined {
  const [x, y, w] = apply(h, [pixel[0], pixel[1], 1]);
  return w > 1e-9 ? [x / w, y / w] : undefined;
}

/** As CSS has it, for an element whose transform's origin is its top left corner. */
export function cssTransform(h: Matrix3): string {
  // By columns, with a third axis that stays. What is behind the eye has a negative w, and is cut off.
  const columns = [
    [h[0][0], h[1][0], 0, h[2][0]],
    [h[0][1], h[1][1], 0, h[2][1]],
    [0, 0, 1, 0],
    [h[0][2], h[1][2], 0, h[2][2]],
  ];
  return `matrix3d(${columns.flat().join(",")})`;
}

/** Whether the picture of `from`, shown by `h`, fills that of `to`. */
export function covers(h: Matrix3, from: Pinhole, to: Pinhole): boolean {
  const corners: [number, number][] = [
    [0, 0],
    [from.width, 0],
    [from.width, from.height],
    [0, from.height],
  ];
  const shown = corners.map((corner) => mapped(h, corner));
  const [a, b, c, d] = shown;
  if (!a || !b || !c || !d) {
    return false;
  }
  // A convex shape contains a rectangle that has its corners on the inner side of every edge. Half
  // a pixel is forgiven: nobody sees it.
  const edges: [[number, number], [number, number]][] = [
    [a, b],
    [b, c],
    [c, d],
    [d, a],
  ];
  return edges.every(([p, q]) => {
    const normal: Vector3 = [p[1] - q[1], q[0] - p[0], 0];
    const slack = 0.5 * Math.hypot(normal[0], normal[1]);
    return [
      [0, 0],
      [to.width, 0],
      [to.width, to.height],
      [0, to.height],
    ].every(([x, y]) => dot(normal, [(x ?? 0) - p[0], (y ?? 0) - p[1], 0]) >= -slack);
  });
}
