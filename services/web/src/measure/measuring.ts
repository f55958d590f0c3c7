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
  /** Another one each time that the tape is put away or cleared. */
  #round = 0;
  #on = false;
  /** Whether something else has its place for a while: what was measured stays. */
  #aside = false;

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

  /** Takes the tape up, as it was put aside, or puts it away. */
  toggle(): void {
    if (this.#on) {
      this.close();
    } else {
      this.#turn(true);
    }
  }

  /** Puts the tape away, and what was measured with it. */
  close(): void {
    this.#turn(false);
    this.#clear();
  }

  /** Leaves its place to something else; the marks of what was measured stay on the street. */
  putAside(): void {
    if (this.#on) {
      this.#turn(false);
      this.#aside = true;
    }
  }

  /** Takes the tape up again if it was put aside. */
  resume(): void {
    if (this.#aside) {
      this.#turn(true);
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
      if (round === this.#round) {
        const places = this.#places.length < 2 ? this.#places : [];
        const met = place && pointed(place, shown.pose.eye, focalLength(shown));
        this.#set(met ? [...places, met] : this.#places);
      }
    })();
    return this.#asked;
  }

  #turn(on: boolean): void {
    this.#on = on;
    this.#aside = false;
    this.panel.root.hidden = !on;
    this.#events.changed(on);
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
