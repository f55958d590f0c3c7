import type { Place } from "../gen/flaneur/v1/render_pb";
import { distance, planDistance, type Vector3 } from "../geometry/vector";
import { positionOf } from "../place/pick";

/** What lies between two places, metres. */
export interface Measurement {
  readonly distance: number;
  readonly horizontal: number;
  /** Up from the first to the second. */
  readonly vertical: number;
  /** One standard deviation of the distance; undefined where that of a place is unknown. */
  readonly uncertainty: number | undefined;
}

export function measure(from: Place, to: Place): Measurement {
  const [a, b] = [positionOf(from), positionOf(to)];
  const known = from.uncertaintyM > 0 && to.uncertaintyM > 0;
  return {
    distance: distance(a, b),
    horizontal: planDistance(a, b),
    vertical: b[2] - a[2],
    // Places are surveyed apart from each other.
    uncertainty: known ? Math.hypot(from.uncertaintyM, to.uncertaintyM) : undefined,
  };
}

/** Millimetres are the survey's own; more is noise. */
export function metres(value: number): string {
  return `${value.toFixed(3)} m`;
}

/** A length to read in passing. */
export function roughMetres(value: number): string {
  return value < 10 ? `${value.toFixed(1)} m` : `${Math.round(value)} m`;
}

/** With its sign, as heights differ. */
export function signedMetres(value: number): string {
  return `${value < 0 ? "−" : "+"}${Math.abs(value).toFixed(3)} m`;
}

/** Uncertainties to two digits that matter. */
export function plusMinus(value: number): string {
  if (value < 0.1) {
    return `± ${(value * 1000).toFixed(0)} mm`;
  }
  return value < 1 ? `± ${(value * 100).toFixed(0)} cm` : `± ${value.toFixed(1)} m`;
}

export function coordinates(place: Vector3): string {
  return place.map((value) => value.toFixed(3)).join(", ");
}
