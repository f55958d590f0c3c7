import type { Gait } from "../motion/walk";

/** Which way a held key goes. */
const WAYS: Readonly<Record<string, Partial<Gait>>> = {
  KeyW: { forward: 1 },
  ArrowUp: { forward: 1 },
  KeyS: { forward: -1 },
  ArrowDown: { forward: -1 },
  KeyA: { right: -1 },
  KeyD: { right: 1 },
  ArrowLeft: { turn: -1 },
  ArrowRight: { turn: 1 },
  PageUp: { tilt: 1 },
  PageDown: { tilt: -1 },
};

/** What a stroke of a key does. */
export interface Strokes {
  /** Enter or Space: what a click in the middle does. */
  act(): void;
  nearestPhotograph(): void;
  level(): void;
  zoom(factor: number): void;
  measure(): void;
  leave(): void;
  help(): void;
  /** From 0. */
  layer(index: number): void;
}

/** What the map understands, beside the keys that zoom. */
const MAP_KEYS: ReadonlySet<string> = new Set([
  "ArrowUp",
  "ArrowDown",
  "ArrowLeft",
  "ArrowRight",
  "Enter",
  " ",
  "Escape",
]);

/** A key walks for as long as it is down, and for so long at least, milliseconds: a tap is a step. */
const SHORTEST_MS = 100;

/** A key that walks. */
interface Press {
  /** As events have it, and frames of the screen. */
  readonly downMs: number;
  up: boolean;
  /** Whether it has made a step. */
  walked: boolean;
}

/** The keys that walk. */
export class Keys {
  readonly #presses = new Map<string, Press>();
  #hurried = false;

  /** `changed` is called when a key that walks goes down or up. */
  constructor(stage: HTMLElement, strokes: Strokes, changed: () => void) {
    window.addEventListener("keydown", (event) => {
      this.#hurried = event.shiftKey;
      if (event.ctrlKey || event.metaKey || event.altKey || isForOthers(event, stage)) {
        return;
      }
      // Where Enter acts is shown to those who use it.
      if (["Tab", "Enter", " ", "m", "M"].includes(event.key)) {
        stage.classList.add("by-keys");
      }
      if (WAYS[event.code]) {
        event.preventDefault();
        const press = this.#presses.get(event.code);
        if (!press || press.up) {
          this.#presses.set(event.code, { downMs: event.timeStamp, up: false, walked: false });
          changed();
        }
      } else if (!event.repeat || isZoom(event.key)) {
        stroke(event, strokes, stage);
      }
    });
    window.addEventListener("keyup", (event) => {
      this.#hurried = event.shiftKey;
      const press = this.#presses.get(event.code);
      if (press) {
        press.up = true;
        changed();
      }
    });
    // Where the keys go up elsewhere nobody is told.
    window.addEventListener("blur", () => {
      this.#presses.clear();
      changed();
    });
  }

  /**
   * The gait of the step that is made now; undefined where nobody walks. A key that went down and
   * up again between two frames makes its step, too.
   */
  step(nowMs: number): Gait | undefined {
    const sum = { forward: 0, right: 0, turn: 0, tilt: 0 };
    for (const [code, press] of this.#presses) {
      if (press.up && press.walked && nowMs - press.downMs >= SHORTEST_MS) {
        this.#presses.delete(code);
        continue;
      }
      press.walked = true;
      const way = WAYS[code];
      sum.forward += way?.forward ?? 0;
      sum.right += way?.right ?? 0;
      sum.turn += way?.turn ?? 0;
      sum.tilt += way?.tilt ?? 0;
    }
    if (this.#presses.size === 0) {
      return undefined;
    }
    const unit = (value: number) => Math.max(-1, Math.min(1, value));
    return {
      forward: unit(sum.forward),
      right: unit(sum.right),
      turn: unit(sum.turn),
      tilt: unit(sum.tilt),
      hurried: this.#hurried,
    };
  }
}

/** Whether the key belongs to a field, a list, a dialog or the map. */
function isForOthers(event: KeyboardEvent, stage: HTMLElement): boolean {
  const target = event.target;
  if (!(target instanceof Element) || target === document.body || target === stage) {
    return false;
  }
  if (target.closest("dialog[open], input[type=text], select, textarea")) {
    return true;
  }
  // The map, buttons and switches keep what they understand.
  if (target.closest(".inset-map")) {
    return MAP_KEYS.has(event.key) || isZoom(event.key);
  }
  const own = target.matches("input")
    ? ["ArrowUp", "ArrowDown", "ArrowLeft", "ArrowRight", "Space", "Enter"]
    : ["Space", "Enter"];
  return own.includes(event.code);
}

function isZoom(key: string): boolean {
  return key === "+" || key === "=" || key === "-";
}

function stroke(event: KeyboardEvent, strokes: Strokes, stage: HTMLElement): void {
  const digit = /^Digit([1-9])$/.exec(event.code)?.[1];
  switch (event.key) {
    case "Enter":
    case " ":
      // Elsewhere on the page they may mean something else.
      if (event.target !== stage && event.target !== document.body) {
        return;
      }
      strokes.act();
      break;
    case "g":
    case "G":
      strokes.nearestPhotograph();
      break;
    case "Home":
      strokes.level();
      break;
    case "+":
    case "=":
      strokes.zoom(1.15);
      break;
    case "-":
      strokes.zoom(1 / 1.15);
      break;
    case "m":
    case "M":
      strokes.measure();
      break;
    case "Escape":
      strokes.leave();
      break;
    case "?":
      strokes.help();
      break;
    default:
      if (!digit) {
        return;
      }
      strokes.layer(Number(digit) - 1);
  }
  event.preventDefault();
}
