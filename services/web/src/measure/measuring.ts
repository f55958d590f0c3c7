import type { Place, Sight } from "../gen/flaneur/v1/render_pb";
import type { Stage } from "../picture/stage";
import { positionOf } from "../place/pick";
import { measure, metres } from "./measurement";
import { MeasurePanel } from "./panel";
import { Ruler } from "./ruler";

export interface MeasuringEvents {
  open(sight: Sight, place: Place): void;
  changed(on: boolean): void;
}

/** The tape: the first click is its beginning, the second its end, the third begins anew. */
export class Measuring {
  readonly panel: MeasurePanel;
  readonly ruler = new Ruler();
  readonly #stage: Stage;
  readonly #events: MeasuringEvents;
  #places: Place[] = [];
  #on = false;

  constructor(stage: Stage, events: MeasuringEvents) {
    this.#stage = stage;
    this.#events = events;
    this.panel = new MeasurePanel({
      close: () => this.close(),
      clear: () => this.#set([]),
      open: events.open,
    });
  }

  get on(): boolean {
    return this.#on;
  }

  toggle(): void {
    this.#on = !this.#on;
    this.panel.root.hidden = !this.#on;
    this.#events.changed(this.#on);
    this.#set([]);
  }

  close(): void {
    if (this.#on) {
      this.toggle();
    }
  }

  /** Before the server's answer. */
  asking(): void {
    this.panel.show(this.#places.length < 2 ? this.#places : [], true);
  }

  /** The server's answer: nothing, where nothing was surveyed. */
  answer(place: Place | undefined): void {
    if (!place) {
      this.#set(this.#places);
    } else {
      this.#set(this.#places.length < 2 ? [...this.#places, place] : [place]);
    }
  }

  #set(places: Place[]): void {
    this.#places = places;
    this.panel.show(places, false);
    const [from, to] = places;
    const label = from && to ? metres(measure(from, to).distance) : "";
    this.ruler.set(places.map(positionOf), label, this.#stage.shown);
  }
}
