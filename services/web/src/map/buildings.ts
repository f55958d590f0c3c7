import type { Clients } from "../api/clients";
import type { Footprint } from "../gen/flaneur/v1/footprint_pb";
import type { Vector3 } from "../geometry/vector";

/** An outline and its holes, in the scene's CRS: x, y of each corner. */
export type Outline = readonly (readonly (readonly [number, number])[])[];

/** The buildings of a scene, as far as they have been asked for. */
export class Buildings {
  readonly #client: Clients["footprints"];
  readonly #scene: string;
  readonly #outlines = new Map<string, readonly Outline[]>();

  constructor(client: Clients["footprints"], scene: string) {
    this.#client = client;
    this.#scene = scene;
  }

  get all(): Iterable<readonly Outline[]> {
    return this.#outlines.values();
  }

  /** Fetches those around a place. */
  async fetch(centre: Vector3, radiusM: number): Promise<void> {
    const batches = this.#client.streamFootprints({
      scene: this.#scene,
      centre: { x: centre[0], y: centre[1] },
      radiusM,
      geometryOnly: true,
    });
    for await (const batch of batches) {
      for (const footprint of batch.footprints) {
        this.#outlines.set(footprint.id, outlinesOf(footprint));
      }
    }
  }

  /** Whether a place in plan is inside of one. */
  contain(x: number, y: number): boolean {
    for (const outlines of this.#outlines.values()) {
      if (outlines.some((outline) => inside(outline, x, y))) {
        return true;
      }
    }
    return false;
  }
}

export function outlinesOf(footprint: Footprint): Outline[] {
  return footprint.polygons.map(({ rings }) =>
    rings.map(({ coordinates }) => {
      const corners: [number, number][] = [];
      for (let at = 0; at + 1 < coordinates.length; at += 2) {
        corners.push([coordinates[at] ?? 0, coordinates[at + 1] ?? 0]);
      }
      return corners;
    }),
  );
}

/** Even-odd: a place in a hole is outside. */
export function inside(outline: Outline, x: number, y: number): boolean {
  let within = false;
  for (const ring of outline) {
    let [px, py] = ring[ring.length - 1] ?? [0, 0];
    for (const [qx, qy] of ring) {
      if (qy > y !== py > y && x < ((px - qx) * (y - qy)) / (py - qy) + qx) {
        within = !within;
      }
      [px, py] = [qx, qy];
    }
  }
  return within;
}
