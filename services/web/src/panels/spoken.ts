import { element } from "../dom";
import { TEXT } from "../strings";

/** How the picture, or the connection, stands. */
export type Quality = keyof typeof TEXT.quality;

/** What lasts for less is not said, milliseconds. */
const LASTING_MS = 1000;

const AWAY: ReadonlySet<Quality> = new Set(["lost", "full", "trouble"]);

/**
 * Tells those who listen how things stand, where it matters and once it has lasted: that there is a
 * picture, that the connection is gone, that it is back. Not each step towards a better picture.
 */
export class Spoken {
  readonly root = element("span", { class: "unseen", role: "status" });
  #heard: Quality | undefined;
  #said: Quality | undefined;
  #timer: ReturnType<typeof setTimeout> | undefined;

  /** How things stand now, and why, where there is a reason. */
  hear(quality: Quality, reason: string): void {
    if (quality === this.#heard) {
      return;
    }
    this.#heard = quality;
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => {
      const text = textAfter(this.#said, quality, reason);
      if (text !== undefined) {
        this.#said = quality;
        this.root.textContent = text;
      }
    }, LASTING_MS);
  }
}

/** What is to be said after something else was; nothing where it is of no consequence. */
export function textAfter(
  said: Quality | undefined,
  quality: Quality,
  reason: string,
): string | undefined {
  if (quality === said || quality === "connecting") {
    return undefined;
  }
  const wasAway = said !== undefined && AWAY.has(said);
  if (wasAway && !AWAY.has(quality)) {
    return [TEXT.connectedAgain, TEXT.quality[quality]].join(". ");
  }
  if (quality === "refining") {
    return undefined;
  }
  return [TEXT.quality[quality], reason].filter((text) => text !== "").join(": ");
}
