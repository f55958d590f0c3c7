import type { Clients } from "./api/clients";
import { reasonOf } from "./api/failure";
import type { Session } from "./api/session";
import type { ScreenPoint } from "./controls/steering";
import type { Panorama } from "./gen/flaneur/v1/panorama_pb";
import type { Place } from "./gen/flaneur/v1/render_pb";
import type { Terrain } from "./ground/terrain";
import type { Measuring } from "./measure/measuring";
import type { Toast } from "./panels/toast";
import type { Catalogue } from "./photographs/catalogue";
import type { Screen } from "./picture/request";
import { facing, standingOn } from "./place/destination";
import { kindOf, pick, positionOf } from "./place/pick";
import type { Layer } from "./state/layer";
import type { Value } from "./state/value";
import { TEXT } from "./strings";
import { lookingAt, type Pose } from "./view/pose";
import type { Visit } from "./visit";

/** What clicks lead to. */
export interface ClicksParts {
  readonly render: Clients["render"];
  readonly scene: string;
  readonly session: Session;
  readonly pose: Value<Pose>;
  readonly layer: Value<Layer>;
  readonly screen: () => Screen;
  readonly visit: Visit;
  readonly terrain: Terrain;
  readonly catalogue: Catalogue;
  readonly measuring: Measuring;
  readonly toast: Toast;
  readonly stand: (panorama: Panorama) => void;
}

/** Clicks and taps on the street. Only the newest counts: an older one's answer may come late. */
export class Clicks {
  readonly #parts: ClicksParts;
  #newest = 0;
  /** What the last click met, for the second half of a double click. */
  #met: Promise<Place | undefined> = Promise.resolve(undefined);

  constructor(parts: ClicksParts) {
    this.#parts = parts;
  }

  /** Goes to the ground, faces a wall, or measures. */
  async once(at: ScreenPoint): Promise<void> {
    const { measuring, toast, visit, pose, terrain } = this.#parts;
    if (measuring.on) {
      // Every click counts, in its turn.
      await measuring.ask(this.#pick(at, true));
      return;
    }
    this.#newest += 1;
    const click = this.#newest;
    this.#met = this.#pick(at, false);
    const place = await this.#met;
    if (click !== this.#newest || !place) {
      return;
    }
    const [x, y] = positionOf(place);
    const now = pose.get();
    const height = (u: number, v: number) => terrain.height(u, v);
    switch (kindOf(place, terrain.height(x, y))) {
      case "ground":
        visit.go(standingOn(now, place));
        break;
      case "wall":
        visit.go(facing(now, place, height));
        break;
      default:
        visit.go(lookingAt(now, positionOf(place)));
    }
    toast.clear();
  }

  /** Goes to the photograph that is nearest to what the first click met. */
  async twice(at: ScreenPoint): Promise<void> {
    if (this.#parts.measuring.on) {
      // Two places may well lie close to each other.
      await this.once(at);
      return;
    }
    this.#newest += 1;
    await this.#goToPhotograph(await this.#met);
  }

  /** Goes to the photograph that is nearest to where one stands. */
  async nearestPhotograph(): Promise<void> {
    this.#newest += 1;
    await this.#goToPhotograph(undefined);
  }

  async #goToPhotograph(place: Place | undefined): Promise<void> {
    const { catalogue, toast, pose, stand } = this.#parts;
    const panorama = catalogue.nearest(place ? positionOf(place) : pose.get().eye);
    if (panorama) {
      stand(panorama);
    } else {
      toast.say(TEXT.noPhotograph);
    }
  }

  async #pick(at: ScreenPoint, photographs: boolean): Promise<Place | undefined> {
    const { render, scene, session, pose, layer, screen, toast } = this.#parts;
    const request = {
      scene,
      pose: pose.get(),
      screen: screen(),
      layer: layer.get(),
      at,
      photographs,
      headers: session.headers,
    };
    try {
      const place = await pick(render, request);
      if (!place) {
        toast.say(TEXT.nothingThere);
      }
      return place;
    } catch (error) {
      toast.say(TEXT.pickFailed(reasonOf(error)));
      return undefined;
    }
  }
}
