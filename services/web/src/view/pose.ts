import { clamp, degrees, fullTurn, radians } from "../geometry/angles";
import type { Matrix3 } from "../geometry/matrix";
import { subtract, type Vector3 } from "../geometry/vector";

/** Where a person stands and looks. Without roll. */
export interface Pose {
  /** In the scene's CRS. */
  readonly eye: Vector3;
  /** Clockwise from grid north, 0 to 360. */
  readonly headingDeg: number;
  /** Up from the horizon, within ± 89. */
  readonly pitchDeg: number;
  /** From the bottom of the picture to its top. */
  readonly fovDeg: number;
}

export const HIGHEST_PITCH_DEG = 89;
export const NARROWEST_FOV_DEG = 5;
export const WIDEST_FOV_DEG = 110;

/** The same pose with its angles where they belong. */
export function normalised(pose: Pose): Pose {
  return {
    eye: pose.eye,
    headingDeg: fullTurn(pose.headingDeg),
    pitchDeg: clamp(pose.pitchDeg, -HIGHEST_PITCH_DEG, HIGHEST_PITCH_DEG),
    fovDeg: clamp(pose.fovDeg, NARROWEST_FOV_DEG, WIDEST_FOV_DEG),
  };
}

/** Rows are the camera's axes in the world: x right, y down, z forward. */
export function camFromWorld(pose: Pose): Matrix3 {
  const heading = radians(pose.headingDeg);
  const pitch = radians(pose.pitchDeg);
  const [sinH, cosH] = [Math.sin(heading), Math.cos(heading)];
  const [sinP, cosP] = [Math.sin(pitch), Math.cos(pitch)];
  return [
    [cosH, -sinH, 0],
    [sinH * sinP, cosH * sinP, -cosP],
    [sinH * cosP, cosH * cosP, sinP],
  ];
}

/** Heading and pitch of a direction of any length. */
export function direction(v: Vector3): { headingDeg: number; pitchDeg: number } {
  return {
    headingDeg: fullTurn(degrees(Math.atan2(v[0], v[1]))),
    pitchDeg: degrees(Math.atan2(v[2], Math.hypot(v[0], v[1]))),
  };
}

/** The pose, turned towards a place. */
export function lookingAt(pose: Pose, place: Vector3): Pose {
  return normalised({ ...pose, ...direction(subtract(place, pose.eye)) });
}

export function samePose(a: Pose, b: Pose): boolean {
  return (
    a.headingDeg === b.headingDeg &&
    a.pitchDeg === b.pitchDeg &&
    a.fovDeg === b.fovDeg &&
    a.eye.every((value, axis) => value === b.eye[axis])
  );
}
