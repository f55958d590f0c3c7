import { element } from "../dom";

/** So long a word stays, milliseconds: at least, and for each of its letters. */
const STAY_MS = 2000;
const LETTER_MS = 60;

/** A word in passing, which is read aloud too. */
export class Toast {
  readonly root = element("div", { class: "toast", role: "status" });
  #timer: ReturnType<typeof setTimeout> | undefined;

  say(text: string): void {
    clearTimeout(this.#timer);
    this.root.textContent = text;
    this.root.classList.add("shown");
    this.#timer = setTimeout(() => this.clear(), STAY_MS + LETTER_MS * text.length);
  }

  clear(): void {
    clearTimeout(this.#timer);
    this.root.classList.remove("shown");
    this.root.textContent = "";
  }
}
