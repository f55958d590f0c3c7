import type { Clients } from "../api/clients";
import type { Panorama } from "../gen/flaneur/v1/panorama_pb";
import { apply, type Matrix3 } from "../geometry/matrix";
import { add, planDistance, type Vector3 } from "../geometry/vector";

/** The panoramas of a scene, as far as they have been asked for. */
export class Catalogue {
  readonly #client: Clients["panoramas"];
  readonly #scene: string;
  readonly #panoramas = new Map<string, Panorama>();

  constructor(client: Clients["panoramas"], scene: string) {
    this.#client = client;
    this.#scene = scene;
  }

  get all(): Iterable<Panorama> {
    return this.#panoramas.values();
  }

  /** Fetches those around a place, or of the whole scene. */
  async fetch(around?: { readonly centre: Vector3; readonly radiusM: number }): Promise<void> {
    const region = around
      ? { centre: { x: around.centre[0], y: around.centre[1] }, radiusM: around.radiusM }
      : {};
    const panoramas = this.#client.streamPanoramas({ scene: this.#scene, ...region });
    for await (const panorama of panoramas) {
      this.#panoramas.set(panorama.id, panorama);
    }
  }

  /** That of a name, which is not farther than `radiusM` from a place. */
  async find(id: string, centre: Vector3, radiusM: number): Promise<Panorama | undefined> {
    if (!this.#panoramas.has(id)) {
      await this.fetch({ centre, radiusM });
    }
    return this.#panoramas.get(id);
  }

  /** The one that is nearest in plan. */
  nearest(place: Vector3): Panorama | undefined {
    let best: { panorama: Panorama; metres: number } | undefined;
    for (const panorama of this.#panoramas.values()) {
      const metres = planDistance(placeOf(panorama), place);
      if (!best || metres < best.metres) {
        best = { panorama, metres };
      }
    }
    return best?.panorama;
  }
}

/** Where a photograph was taken: the centre of a camera, which the rig carries somewhere above its origin. */
export function placeOf(panorama: Panorama, camera = panorama.cameras[0]): Vector3 {
  const { x, y, z } = panorama.position ?? { x: Number.NaN, y: Number.NaN, z: Number.NaN };
  const inRig = camera?.positionInRig;
  if (!inRig) {
    return [x, y, z];
  }
  const [a = 1, b = 0, c = 0, d = 0, e = 1, f = 0, g = 0, h = 0, i = 1] =
    panorama.worldFromRig?.rows ?? [];
  const worldFromRig: Matrix3 = [
    [a, b, c],
    [d, e, f],
    [g, h, i],
  ];
  return add([x, y, z], apply(worldFromRig, [inRig.x, inRig.y, inRig.z]));
}
