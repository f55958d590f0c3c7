import { element } from "../dom";
import { degrees, fullTurn } from "../geometry/angles";
import type { Vector3 } from "../geometry/vector";
import { roughMetres } from "../measure/measurement";
import { TEXT } from "../strings";
import type { InsetMap } from "./inset";

/** A stroke of an arrow shows so much more, pixels. */
const STEP_PX = 30;
/** A stroke of plus doubles twice in three. */
const ZOOM = 1.6;
/** What is in the middle is said once nothing has moved for so long, milliseconds. */
const SPEECH_MS = 400;
/** Nearer than that one is there, metres. */
const HERE_M = 1;

/** What the keys of a map act on. */
export interface MapKeysParts {
  readonly map: () => InsetMap | undefined;
  /** Where one stands. */
  readonly eye: () => Vector3;
  /** What a click in the middle does. */
  readonly go: () => void;
  /** The photograph in the middle. */
  readonly photograph: () => string | undefined;
  /** Back to the street. */
  readonly leave: () => void;
}

/** Arrows move the map, plus and minus zoom it, Enter goes to its middle, which is said aloud. */
export class MapKeys {
  /** What is in the middle, for those who listen. */
  readonly words = element("p", { class: "unseen", role: "status" });
  readonly #parts: MapKeysParts;
  #timer: ReturnType<typeof setTimeout> | undefined;

  constructor(surface: HTMLElement, parts: MapKeysParts) {
    this.#parts = parts;
    surface.addEventListener("keydown", (event) => {
      if (!event.ctrlKey && !event.metaKey && !event.altKey && this.#act(event.key)) {
        event.preventDefault();
        this.#speakSoon();
      }
    });
    surface.addEventListener("focus", () => this.#speakSoon());
  }

  zoom(factor: number): void {
    this.#parts.map()?.zoom(factor);
    this.#speakSoon();
  }

  nearer(): void {
    this.zoom(ZOOM);
  }

  farther(): void {
    this.zoom(1 / ZOOM);
  }

  /** Whether the key means something. */
  #act(key: string): boolean {
    const map = this.#parts.map();
    switch (key) {
      case "ArrowUp":
        map?.pan(0, -STEP_PX);
        return true;
      case "ArrowDown":
        map?.pan(0, STEP_PX);
        return true;
      case "ArrowLeft":
        map?.pan(-STEP_PX, 0);
        return true;
      case "ArrowRight":
        map?.pan(STEP_PX, 0);
        return true;
      case "+":
      case "=":
        this.nearer();
        return true;
      case "-":
        this.farther();
        return true;
      case "Enter":
      case " ":
        this.#parts.go();
        return true;
      case "Escape":
        this.#parts.leave();
        return true;
      default:
        return false;
    }
  }

  #speakSoon(): void {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => {
      this.words.textContent = this.#said();
    }, SPEECH_MS);
  }

  #said(): string {
    const map = this.#parts.map();
    if (!map) {
      return "";
    }
    const [x, y] = map.centre;
    const eye = this.#parts.eye();
    const [east, north] = [x - eye[0], y - eye[1]];
    const metres = Math.hypot(east, north);
    const eighth = Math.round(fullTurn(degrees(Math.atan2(east, north))) / 45) % 8;
    const way = TEXT.compass[eighth] ?? "";
    const where = metres < HERE_M ? TEXT.here : TEXT.away(`${roughMetres(metres)} ${way}`);
    const photograph = this.#parts.photograph();
    return TEXT.mapMiddle(where, photograph);
  }
}
