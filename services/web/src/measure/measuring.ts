import type { Place, Sight } from "../gen/flaneur/v1/render_pb";
import type { Stage } from "../picture/stage";
import { positionOf } from "../place/pick";
import { focalLength, project } from "../view/pinhole";
import { measure, metres, type Pointed, pointed } from "./measurement";
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
  #places: Pointed[] = [];
  /** What was asked last. */
  #asked: Promise<void> = Promise.resolve();
  /** Another one each time that the tape is taken up or cleared. */
  #round = 0;
  #on = false;

  /** `reference` says what coordinates refer to. */
  constructor(stage: Stage, reference: string, events: MeasuringEvents) {
    this.#stage = stage;
    this.#events = events;
    this.panel = new MeasurePanel(reference, {
      close: () => this.close(),
      clear: () => this.#clear(),
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
    this.#clear();
  }

  close(): void {
    if (this.#on) {
      this.toggle();
    }
  }

  /** Takes the server's answer: nothing, where nothing was surveyed. Answers count in the order of clicks. */
  ask(answer: Promise<Place | undefined>): Promise<void> {
    const round = this.#round;
    const { shown } = this.#stage;
    this.panel.show(this.#places.length < 2 ? this.#places : [], true);
    const before = this.#asked;
    this.#asked = (async () => {
      await before;
      const place = await answer;
      // Put away meanwhile, or begun anew.
      if (this.#on && round === this.#round) {
        const places = this.#places.length < 2 ? this.#places : [];
        const met = place && pointed(place, shown.pose.eye, focalLength(shown));
        this.#set(met ? [...places, met] : this.#places);
      }
    })();
    return this.#asked;
  }

  #clear(): void {
    this.#round += 1;
    this.#set([]);
  }

  #set(places: Pointed[]): void {
    this.#places = places;
    this.panel.show(places, false);
    const [from, to] = places;
    const measured = from && to && measure(from, to);
    const label = measured ? metres(measured.distance, measured.uncertainty) : "";
    const ends = places.map(({ place }) => positionOf(place));
    const { shown } = this.#stage;
    this.ruler.set(ends, label, shown);
    this.panel.spare(ends.flatMap((end) => [project(shown, end)].filter((at) => at !== undefined)));
  }
}
