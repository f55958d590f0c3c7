import type { Clients } from "../api/clients";
import type { GroundLayout, Scene } from "../gen/flaneur/v1/scene_pb";
import { decodeTile, type Heights, heightAt } from "./tile";

/** Terrain is fetched so far around the eye, metres, ... */
const REACH_M = 80;
/** ... once the eye has left what was fetched around by so much. */
const STRIDE_M = 40;
/** Tiles beyond these are forgotten, the oldest first. */
const MOST_TILES = 256;

/** The height of the ground around the eye, as far as it has come. */
export class Terrain {
  readonly #client: Clients["ground"];
  readonly #scene: string;
  readonly #layout: GroundLayout | undefined;
  readonly #tiles = new Map<string, Heights>();
  #centre: readonly [number, number] | undefined;

  constructor(client: Clients["ground"], scene: Scene) {
    this.#client = client;
    this.#scene = scene.name;
    this.#layout = scene.ground;
  }

  /** Fetches what is missing around a place; resolves once it is there. */
  async around(x: number, y: number): Promise<void> {
    const centre = this.#centre;
    if (!this.#layout || (centre && Math.hypot(x - centre[0], y - centre[1]) < STRIDE_M)) {
      return;
    }
    this.#centre = [x, y];
    try {
      const request = { scene: this.#scene, centre: { x, y }, radiusM: REACH_M, step: 1 };
      for await (const tile of this.#client.streamGround(request)) {
        const heights = decodeTile(tile);
        if (heights) {
          this.#keep(`${tile.column},${tile.row}`, heights);
        }
      }
    } catch {
      // Without terrain the eye stays level; the next step tries again.
      this.#centre = centre;
    }
  }

  /** Metres; undefined where it is not known, or not yet. */
  height(x: number, y: number): number | undefined {
    const layout = this.#layout;
    if (!layout?.origin) {
      return undefined;
    }
    const column = Math.floor((x - layout.origin.x) / layout.tileM);
    const row = Math.floor((y - layout.origin.y) / layout.tileM);
    const tile = this.#tiles.get(`${column},${row}`);
    return tile && heightAt(tile, x, y);
  }

  #keep(key: string, heights: Heights): void {
    this.#tiles.delete(key);
    this.#tiles.set(key, heights);
    const [oldest] = this.#tiles.keys();
    if (this.#tiles.size > MOST_TILES && oldest !== undefined) {
      this.#tiles.delete(oldest);
    }
  }
}
