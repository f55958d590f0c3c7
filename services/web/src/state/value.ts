/** A value that says when it changes. */
export class Value<T> {
  #value: T;
  readonly #listeners = new Set<(value: T) => void>();

  constructor(value: T) {
    this.#value = value;
  }

  get(): T {
    return this.#value;
  }

  /** Tells the listeners, unless the value is what it was. */
  set(value: T): void {
    if (Object.is(this.#value, value)) {
      return;
    }
    this.#value = value;
    for (const listener of this.#listeners) {
      listener(value);
    }
  }

  /** Calls the listener with the value as it is, and after each change. */
  watch(listener: (value: T) => void): void {
    this.#listeners.add(listener);
    listener(this.#value);
  }
}
