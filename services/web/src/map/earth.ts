import type { Scene } from "../gen/flaneur/v1/scene_pb";

/** Longitude and latitude, degrees. */
export type LngLat = [number, number];

/** Metres for a degree of latitude, about. */
const METRES_A_DEGREE = 111_320;

/** Where the scene's places are on a map of the Earth, to first order, and back. */
export interface Earth {
  toLngLat(x: number, y: number): LngLat;
  toScene(lngLat: LngLat): [number, number];
}

/** That of a scene. Where it is tied to no place on Earth, it lies where longitude meets equator. */
export function earthOf(scene: Scene): Earth {
  const [x0, y0] = [scene.origin?.x ?? 0, scene.origin?.y ?? 0];
  const { origin, longitudePerM: u, latitudePerM: v } = scene.geographic ?? {};
  const tied = origin && u && v && Math.abs(u.x * v.y - u.y * v.x) > 1e-14;
  const [lng0, lat0] = tied ? [origin.longitudeDeg, origin.latitudeDeg] : [0, 0];
  const [a, b, c, d] = tied
    ? [u.x, u.y, v.x, v.y]
    : [1 / METRES_A_DEGREE, 0, 0, 1 / METRES_A_DEGREE];
  const determinant = a * d - b * c;
  return {
    toLngLat(x, y) {
      const [dx, dy] = [x - x0, y - y0];
      return [lng0 + a * dx + b * dy, lat0 + c * dx + d * dy];
    },
    toScene([lng, lat]) {
      const [p, q] = [lng - lng0, lat - lat0];
      return [x0 + (d * p - b * q) / determinant, y0 + (a * q - c * p) / determinant];
    },
  };
}
