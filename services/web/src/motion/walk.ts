import { radians } from "../geometry/angles";
import type { Vector3 } from "../geometry/vector";
import { normalised, type Pose } from "../view/pose";
import { slid, type Walls } from "./slide";

/** What the feet and the head want: each from -1 to 1. */
export interface Gait {
  readonly forward: number;
  readonly right: number;
  /** Clockwise. */
  readonly turn: number;
  /** Up. */
  readonly tilt: number;
  readonly hurried: boolean;
}

const WALK_M_PER_S = 3;
const HURRY_M_PER_S = 9;
const TURN_DEG_PER_S = 75;

/** Height of the ground at a place in plan; undefined where it is not known. */
export type GroundHeight = (x: number, y: number) => number | undefined;

/**
 * The pose after so many seconds. Feet stay on the ground: the eye keeps its height above it, where
 * the ground is known on both sides of the step. One goes along walls, not through them.
 */
export function walked(
  pose: Pose,
  gait: Gait,
  seconds: number,
  ground: GroundHeight,
  walls: Walls,
): Pose {
  const heading = radians(pose.headingDeg);
  const length = Math.hypot(gait.forward, gait.right);
  const speed = gait.hurried ? HURRY_M_PER_S : WALK_M_PER_S;
  // Askew is no faster than ahead.
  const metres = (speed * seconds) / Math.max(length, 1);
  const [fromX, fromY] = pose.eye;
  const [dx, dy] = slid(
    [fromX, fromY],
    [
      metres * (gait.forward * Math.sin(heading) + gait.right * Math.cos(heading)),
      metres * (gait.forward * Math.cos(heading) - gait.right * Math.sin(heading)),
    ],
    walls,
  );
  const [x, y] = [fromX + dx, fromY + dy];
  const [before, after] = [ground(fromX, fromY), ground(x, y)];
  const rise = before === undefined || after === undefined ? 0 : after - before;
  const eye: Vector3 = [x, y, pose.eye[2] + rise];
  // With a narrow view a degree is a long way.
  const turned = TURN_DEG_PER_S * seconds * Math.min(pose.fovDeg / 65, 1);
  return normalised({
    ...pose,
    eye: length > 0 ? eye : pose.eye,
    headingDeg: pose.headingDeg + gait.turn * turned,
    pitchDeg: pose.pitchDeg + gait.tilt * turned,
  });
}
