/** How long it takes to go so many metres, milliseconds: 100 + 30 √d. */
export function flightMs(metres: number): number {
  return 100 + 30 * Math.sqrt(Math.max(metres, 0));
}

/** Starts and ends at rest: 0 at 0, 1 at 1, and clamped beyond. */
export function easeInOut(t: number): number {
  const x = Math.min(Math.max(t, 0), 1);
  return x * x * (3 - 2 * x);
}
