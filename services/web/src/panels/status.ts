import type { SessionState } from "../api/session";
import { element } from "../dom";
import type { Frame } from "../gen/flaneur/v1/render_pb";
import { TEXT } from "../strings";
import { type Quality, Spoken } from "./spoken";

/** How good the picture is and how old, and how far loading has come. */
export class StatusPanel {
  readonly root: HTMLElement;
  readonly progress: HTMLElement;
  readonly #dot = element("span", { class: "dot", "aria-hidden": "true" });
  readonly #quality = element("span", { class: "quality" });
  readonly #spoken = new Spoken();
  readonly #detail = element("span", { class: "aside" });
  readonly #age = element("span", { class: "aside age" });
  readonly #retry = element("button", { type: "button", class: "text" }, TEXT.retryNow);
  readonly #bar = element("div", { class: "bar" });
  #state: SessionState = { kind: "connecting" };
  #frame: Frame | undefined;
  #frameMs = 0;
  /** Sequence of the newest view that was asked for. */
  #wanted = 0n;
  /** Most parts that were to come since the last final picture. */
  #most = 0n;

  constructor(retry: () => void) {
    this.#retry.hidden = true;
    this.#retry.addEventListener("click", retry);
    this.root = element(
      "div",
      { class: "status floating", "data-quality": "connecting" },
      this.#dot,
      this.#quality,
      this.#detail,
      this.#age,
      this.#retry,
      this.#spoken.root,
    );
    this.progress = element(
      "div",
      {
        class: "progress",
        role: "progressbar",
        "aria-label": TEXT.progress,
        "aria-valuemin": 0,
        "aria-valuemax": 100,
      },
      this.#bar,
    );
    this.#draw();
    // Ages grow by themselves.
    setInterval(() => this.#drawTimes(), 1000);
  }

  session(state: SessionState): void {
    this.#state = state;
    this.#draw();
  }

  wanted(sequence: bigint): void {
    this.#wanted = sequence;
    this.#draw();
  }

  frame(frame: Frame): void {
    this.#frame = frame;
    this.#frameMs = performance.now();
    if (frame.final) {
      this.#most = 0n;
    } else if (frame.remaining > this.#most) {
      this.#most = frame.remaining;
    }
    this.#draw();
  }

  get quality(): Quality {
    const frame = this.#frame;
    if (this.#state.kind !== "live") {
      return this.#state.kind;
    }
    if (!frame || (!frame.complete && !frame.final)) {
      return "loading";
    }
    if (frame.final && frame.sequence === this.#wanted) {
      return frame.fault ? "fault" : "final";
    }
    return "refining";
  }

  #draw(): void {
    const quality = this.quality;
    this.root.dataset.quality = quality;
    this.#quality.textContent = TEXT.quality[quality];
    this.#spoken.hear(quality, this.#reason());
    this.#retry.hidden = !["lost", "full", "trouble"].includes(quality);
    this.root.title = this.#frame?.fault ?? "";
    this.#drawTimes();
    const remaining = this.#frame?.remaining ?? 0n;
    const busy = quality === "refining" || quality === "loading" || quality === "connecting";
    const known = busy && this.#most > 0n && remaining > 0n;
    this.progress.hidden = !busy;
    this.progress.classList.toggle("unknown", !known);
    if (known) {
      const part = 1 - Number(remaining) / Number(this.#most);
      this.#bar.style.transform = `scaleX(${part.toFixed(3)})`;
      this.progress.setAttribute("aria-valuenow", String(Math.round(100 * part)));
    } else {
      this.progress.removeAttribute("aria-valuenow");
    }
  }

  #drawTimes(): void {
    const frame = this.#frame;
    const now = performance.now();
    const set = (where: HTMLElement, text: string) => {
      if (where.textContent !== text) {
        where.textContent = text;
      }
    };
    set(this.#age, frame ? TEXT.age((now - this.#frameMs) / 1000) : "");
    set(this.#detail, this.#detailNow(now));
  }

  /** Why it stands so, where somebody has said. */
  #reason(): string {
    const state = this.#state;
    return "reason" in state ? state.reason : (this.#frame?.fault ?? "");
  }

  #detailNow(now: number): string {
    const state = this.#state;
    const frame = this.#frame;
    switch (state.kind) {
      case "lost":
      case "full":
      case "trouble":
        return [state.reason, TEXT.retryIn(Math.ceil((state.retryAtMs - now) / 1000))]
          .filter((text) => text !== "")
          .join(" · ");
      case "refused":
        return state.reason;
      case "resting":
        return TEXT.resting;
      default:
        if (!frame || this.quality === "final") {
          return "";
        }
        return frame.fault || (frame.remaining > 0n ? TEXT.remaining(frame.remaining) : "");
    }
  }
}
