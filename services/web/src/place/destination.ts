import type { Place } from "../gen/flaneur/v1/render_pb";
import { clamp } from "../geometry/angles";
import { planDistance, type Vector3 } from "../geometry/vector";
import type { GroundHeight } from "../motion/walk";
import { EYE_HEIGHT_M } from "../state/start";
import { lookingAt, type Pose } from "../view/pose";
import { positionOf } from "./pick";

/** One stands before a wall no nearer, ... */
const NEAREST_M = 3;
/** ... and no farther, metres. */
const FARTHEST_M = 10;
/** Farther away one turns to a wall, and stays. */
const REACH_M = 30;
/** One does not crane one's neck further, degrees. */
const NECK_DEG = 30;

/** Standing on the place, looking as before. */
export function standingOn(pose: Pose, place: Place): Pose {
  const [x, y, z] = positionOf(place);
  return { ...pose, eye: [x, y, z + EYE_HEIGHT_M] };
}

/**
 * In front of a wall's place, looking straight at it. What is far is looked at from where one
 * stands.
 */
export function facing(pose: Pose, place: Place, ground: GroundHeight): Pose {
  const at = positionOf(place);
  const normal: Vector3 = [place.normal?.x ?? 0, place.normal?.y ?? 0, 0];
  const length = Math.hypot(normal[0], normal[1]);
  const towards = (eye: Vector3): Pose => {
    const turned = lookingAt({ ...pose, eye }, at);
    return { ...turned, pitchDeg: clamp(turned.pitchDeg, -NECK_DEG, NECK_DEG) };
  };
  if (length < 0.1 || planDistance(at, pose.eye) > REACH_M) {
    return towards(pose.eye);
  }
  const [nx, ny] = [normal[0] / length, normal[1] / length];
  const off = (pose.eye[0] - at[0]) * nx + (pose.eye[1] - at[1]) * ny;
  const away = clamp(off, NEAREST_M, FARTHEST_M);
  const [x, y] = [at[0] + nx * away, at[1] + ny * away];
  const [before, after] = [ground(pose.eye[0], pose.eye[1]), ground(x, y)];
  const rise = before === undefined || after === undefined ? 0 : after - before;
  return towards([x, y, pose.eye[2] + rise]);
}
