import type { ScreenPoint, Steering } from "./steering";

/** A pointer that moved less, CSS pixels, ... */
const CLICK_PX = 6;
/** ... and was up again so soon clicked, milliseconds. */
const CLICK_MS = 500;
/** Two clicks within so long, and near each other, are a double click. */
const TWICE_MS = 350;
const TWICE_PX = 24;
/** A notch of a mouse's wheel (100 px) zooms by a seventh. */
const WHEEL_RATE = 0.0014;

interface Touch {
  readonly start: ScreenPoint;
  readonly startMs: number;
  last: ScreenPoint;
  moved: boolean;
}

/** Mouse, pen and fingers on the stage: one looks around, two pinch, a click or tap acts. */
export function steerByPointers(host: HTMLElement, steering: Steering): void {
  const touches = new Map<number, Touch>();
  let lastClick: { at: ScreenPoint; ms: number } | undefined;

  const place = (event: MouseEvent): ScreenPoint => {
    const box = host.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };

  host.addEventListener("pointerdown", (event) => {
    if (event.pointerType === "mouse" && event.button !== 0) {
      return;
    }
    // A capture may be refused for a pointer that is gone already.
    try {
      host.setPointerCapture(event.pointerId);
    } catch {
      return;
    }
    const at = place(event);
    // Whoever uses two fingers does not tap with either.
    const moved = touches.size > 0;
    for (const touch of touches.values()) {
      touch.moved = true;
    }
    host.classList.remove("by-keys");
    touches.set(event.pointerId, { start: at, startMs: event.timeStamp, last: at, moved });
    host.classList.add("held");
  });

  host.addEventListener("pointermove", (event) => {
    const touch = touches.get(event.pointerId);
    if (!touch) {
      return;
    }
    const at = place(event);
    touch.moved ||= apart(at, touch.start) > CLICK_PX;
    if (!touch.moved) {
      return;
    }
    const other = [...touches].find(([id]) => id !== event.pointerId)?.[1];
    if (other) {
      const [before, after] = [apart(touch.last, other.last), apart(at, other.last)];
      const middle: ScreenPoint = [(at[0] + other.last[0]) / 2, (at[1] + other.last[1]) / 2];
      if (before > 10 && after > 10) {
        steering.zoom(after / before, middle);
      }
      // Each finger moves the middle by half.
      steering.drag((at[0] - touch.last[0]) / 2, (at[1] - touch.last[1]) / 2);
    } else {
      steering.drag(at[0] - touch.last[0], at[1] - touch.last[1]);
    }
    touch.last = at;
  });

  const lift = (event: PointerEvent, counts: boolean) => {
    const touch = touches.get(event.pointerId);
    touches.delete(event.pointerId);
    host.classList.toggle("held", touches.size > 0);
    if (!touch || !counts || touch.moved || event.timeStamp - touch.startMs > CLICK_MS) {
      return;
    }
    const twice =
      lastClick !== undefined &&
      event.timeStamp - lastClick.ms < TWICE_MS &&
      apart(touch.start, lastClick.at) < TWICE_PX;
    lastClick = twice ? undefined : { at: touch.start, ms: event.timeStamp };
    if (twice) {
      steering.actTwice(touch.start);
    } else {
      steering.act(touch.start);
    }
  };
  host.addEventListener("pointerup", (event) => lift(event, true));
  host.addEventListener("pointercancel", (event) => lift(event, false));

  host.addEventListener(
    "wheel",
    (event) => {
      // Else the page itself would be zoomed or scrolled.
      event.preventDefault();
      const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 33 : 1;
      // Browsers tell a pinch on a touchpad as small turns of a wheel with Ctrl.
      const pinch = event.ctrlKey ? 6 : 1;
      const delta = Math.max(-300, Math.min(300, event.deltaY * lines * pinch));
      steering.zoom(Math.exp(-delta * WHEEL_RATE), place(event));
    },
    { passive: false },
  );
}

function apart(a: ScreenPoint, b: ScreenPoint): number {
  return Math.hypot(a[0] - b[0], a[1] - b[1]);
}
