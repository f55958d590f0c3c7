const FIRST_MS = 400;
const LONGEST_MS = 10_000;

/**
 * How long to wait before the next attempt, milliseconds: twice as long after each that failed, up
 * to ten seconds, of which a random part from a half on, so that all pages do not come back at the
 * same moment. No sooner than the server would have it.
 *
 * @param failures attempts that failed so far, from 1
 * @param random from 0 (included) to 1 (excluded)
 * @param least what the server says, if it does, milliseconds
 */
export function waitMs(failures: number, random: number, least = 0): number {
  const whole = Math.min(FIRST_MS * 2 ** Math.max(failures - 1, 0), LONGEST_MS);
  return Math.max(whole * (0.5 + 0.5 * random), least * (1 + 0.5 * random));
}
