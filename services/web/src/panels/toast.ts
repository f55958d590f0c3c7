import { element } from "../dom";

/** So long a word stays, milliseconds. */
const STAY_MS = 2600;

/** A word in passing, which is read aloud too. */
export class Toast {
  readonly root = element("div", { class: "toast", role: "status" });
  #timer: ReturnType<typeof setTimeout> | undefined;

  say(text: string): void {
    clearTimeout(this.#timer);
    this.root.textContent = text;
    this.root.classList.add("shown");
    this.#timer = setTimeout(() => this.clear(), STAY_MS);
  }

  clear(): void {
    clearTimeout(this.#timer);
    this.root.classList.remove("shown");
    this.root.textContent = "";
  }
}
