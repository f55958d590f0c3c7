import type { Place } from "../gen/flaneur/v1/render_pb";
import { distance, length, planDistance, subtract, type Vector3 } from "../geometry/vector";
import { positionOf } from "../place/pick";

/** A place, and how it was pointed at. */
export interface Pointed {
  readonly place: Place;
  /** How far it may be from what was meant, metres (one standard deviation); undefined where that is unknown. */
  readonly off: number | undefined;
}

/** No surface is seen more askew, as a sine: it is an edge. */
const ASKEW = 0.1;

/**
 * A place that was clicked from `eye` in a picture of this focal length, pixels of the screen. A hand is a
 * pixel off, and the surface may be nearer or farther than it was surveyed: seen askew, both are farther
 * along it.
 */
export function pointed(place: Place, eye: Vector3, focal: number): Pointed {
  const { x = 0, y = 0, z = 0 } = place.normal ?? {};
  const ray = subtract(positionOf(place), eye);
  const away = length(ray);
  const facing = Math.abs(x * ray[0] + y * ray[1] + z * ray[2]) / Math.max(away, 1e-9);
  const across = Math.hypot(away / focal, place.uncertaintyM);
  const off = place.uncertaintyM > 0 ? across / Math.max(facing, ASKEW) : undefined;
  return { place, off };
}

/** What lies between two places, metres. */
export interface Measurement {
  readonly distance: number;
  readonly horizontal: number;
  /** Up from the first to the second. */
  readonly vertical: number;
  /** One standard deviation of the distance; undefined where that of a place is unknown. */
  readonly uncertainty: number | undefined;
}

export function measure(from: Pointed, to: Pointed): Measurement {
  const [a, b] = [positionOf(from.place), positionOf(to.place)];
  return {
    distance: distance(a, b),
    horizontal: planDistance(a, b),
    vertical: b[2] - a[2],
    // Places are surveyed apart from each other, and so are they clicked.
    uncertainty:
      from.off !== undefined && to.off !== undefined ? Math.hypot(from.off, to.off) : undefined,
  };
}

/** From here on millimetres mean nothing, metres. */
const COARSE_M = 0.1;
/** Metres of a degree of latitude. */
const DEGREE_M = 111_320;

/** Millimetres are the survey's own; more is noise. Centimetres where it is `sure` of decimetres alone. */
export function metres(value: number, sure?: number): string {
  return `${value.toFixed(digits(sure))} m`;
}

function digits(sure: number | undefined): number {
  return sure !== undefined && sure >= COARSE_M ? 2 : 3;
}

/** A length to read in passing. */
export function roughMetres(value: number): string {
  return value < 10 ? `${value.toFixed(1)} m` : `${Math.round(value)} m`;
}

/** With its sign, as heights differ. */
export function signedMetres(value: number, sure?: number): string {
  return `${value < 0 ? "−" : "+"}${metres(Math.abs(value), sure)}`;
}

/** Uncertainties to two digits that matter. */
export function plusMinus(value: number): string {
  if (value < 0.1) {
    return `± ${(value * 1000).toFixed(0)} mm`;
  }
  return value < 1 ? `± ${(value * 100).toFixed(0)} cm` : `± ${value.toFixed(1)} m`;
}

export function coordinates(place: Vector3, sure?: number): string {
  return place.map((value) => value.toFixed(digits(sure))).join(", ");
}

/** Latitude and longitude: the last digit is about a third of what they are sure of, a centimetre where that is unknown. */
export function geographic(latitudeDeg: number, longitudeDeg: number, sure: number): string {
  const third = sure > 0 ? sure / 3 : 0.01;
  const places = Math.min(Math.max(Math.round(Math.log10(DEGREE_M / third)), 4), 8);
  return `${latitudeDeg.toFixed(places)}, ${longitudeDeg.toFixed(places)}`;
}
