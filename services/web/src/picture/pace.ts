import type { Frame } from "../gen/flaneur/v1/render_pb";
import type { Effort } from "./request";

/** A frame on the way should not take the server longer, milliseconds. */
const AIM_MS = 80;
/**
 * Sizes on the way, pixels. Below these the server makes its own pictures coarser, and knows better
 * where.
 */
const LARGE = 1 << 20;
const SMALL = 1 << 19;
/** Turning shows what lies beside the picture before the next one is there. */
const TURNING_MARGIN = 1.2;

/**
 * How large pictures are while one moves. It goes by what the server's frames took: large ones from
 * a quick server, smaller ones from one that would fall behind.
 */
export class Pace {
  /** Milliseconds for a million pixels, smoothed; a guess before the first frame. */
  #cost = 150;

  /** From a view to its frame, milliseconds, smoothed. */
  #delay = 150;

  /** How long a frame takes to come, milliseconds. */
  get delayMs(): number {
    return this.#delay;
  }

  /** Takes note of what a frame took; final ones take as long as they need, and say nothing. */
  took(frame: Frame): void {
    const pixels = (frame.view?.width ?? 0) * (frame.view?.height ?? 0);
    if (!frame.final && pixels > 0) {
      const cost = ((frame.renderMs + frame.encodeMs) * 1e6) / pixels;
      this.#cost += 0.25 * (cost - this.#cost);
      this.#delay += 0.25 * (frame.latencyMs - this.#delay);
    }
  }

  moving(turning: boolean): Effort {
    const pixels = (LARGE * this.#cost) / 1e6 <= AIM_MS ? LARGE : SMALL;
    return { pixels, margin: turning ? TURNING_MARGIN : 1 };
  }
}
