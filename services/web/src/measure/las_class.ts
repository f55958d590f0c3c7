/** Names of ASPRS LAS 1.4-R15, table 17. */
const NAMES: Readonly<Record<number, string>> = {
  0: "never classified",
  1: "unclassified",
  2: "ground",
  3: "low vegetation",
  4: "medium vegetation",
  5: "high vegetation",
  6: "building",
  7: "low point (noise)",
  8: "model key point (reserved since LAS 1.4)",
  9: "water",
  10: "rail",
  11: "road surface",
  12: "overlap (reserved since LAS 1.4)",
  13: "wire, guard (shield)",
  14: "wire, conductor (phase)",
  15: "transmission tower",
  16: "wire-structure connector (insulator)",
  17: "bridge deck",
  18: "high noise",
  19: "overhead structure",
  20: "ignored ground",
  21: "snow",
  22: "temporal exclusion",
};
/** From here on a class means what its user says. */
const USERS = 64;

/** What a class of LAS is, in words, and its number. */
export function lasClass(code: number): string {
  const name = NAMES[code] ?? (code < USERS ? "reserved by LAS" : "defined by the survey");
  return `${name}, class ${code}`;
}
