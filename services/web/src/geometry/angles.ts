const DEGREES = Math.PI / 180;

export function radians(degrees: number): number {
  return degrees * DEGREES;
}

export function degrees(radians: number): number {
  return radians / DEGREES;
}

/** The same direction from 0 (included) to 360 degrees (excluded). */
export function fullTurn(degrees: number): number {
  if (degrees >= 0 && degrees < 360) {
    return degrees;
  }
  const turned = ((degrees % 360) + 360) % 360;
  // What is a hair below zero rounds up to a full turn.
  return turned === 360 ? 0 : turned;
}

/** The short way from one heading to another, -180 (included) to 180 degrees (excluded). */
export function shortTurn(from: number, to: number): number {
  return fullTurn(to - from + 180) - 180;
}

export function clamp(value: number, low: number, high: number): number {
  return Math.min(Math.max(value, low), high);
}
