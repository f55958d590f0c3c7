import type { Vector3 } from "./vector";

/** A matrix of three by three, row by row. */
export type Matrix3 = readonly [Vector3, Vector3, Vector3];

export function multiply(a: Matrix3, b: Matrix3): Matrix3 {
  const row = (r: Vector3): Vector3 => [
    r[0] * b[0][0] + r[1] * b[1][0] + r[2] * b[2][0],
    r[0] * b[0][1] + r[1] * b[1][1] + r[2] * b[2][1],
    r[0] * b[0][2] + r[1] * b[1][2] + r[2] * b[2][2],
  ];
  return [row(a[0]), row(a[1]), row(a[2])];
}

export function transpose(a: Matrix3): Matrix3 {
  return [
    [a[0][0], a[1][0], a[2][0]],
    [a[0][1], a[1][1], a[2][1]],
    [a[0][2], a[1][2], a[2][2]],
  ];
}

export function apply(a: Matrix3, v: Vector3): Vector3 {
  const row = (r: Vector3) => r[0] * v[0] + r[1] * v[1] + r[2] * v[2];
  return [row(a[0]), row(a[1]), row(a[2])];
}
