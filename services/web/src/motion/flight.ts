import { shortTurn } from "../geometry/angles";
import { distance, mix } from "../geometry/vector";
import { normalised, type Pose } from "../view/pose";
import { easeInOut, flightMs } from "./easing";

/** A way from one pose to another, eased. */
export interface Flight {
  readonly from: Pose;
  readonly to: Pose;
  /** As `performance.now()` has it. */
  readonly startMs: number;
  readonly durationMs: number;
}

/** Turning on the spot takes as long as going this far for a whole half turn. */
const HALF_TURN_M = 100;

/** Starts now; `still`: at its end at once, for people who want no motion. */
export function flight(from: Pose, to: Pose, startMs: number, still: boolean): Flight {
  const turn = Math.abs(shortTurn(from.headingDeg, to.headingDeg));
  const turned = (HALF_TURN_M * Math.max(turn, Math.abs(to.pitchDeg - from.pitchDeg))) / 180;
  const metres = Math.max(distance(from.eye, to.eye), turned);
  return { from, to, startMs, durationMs: still ? 0 : flightMs(metres) };
}

/** The pose at a time, and whether that is the last one. */
export function poseAt(flight: Flight, nowMs: number): { pose: Pose; done: boolean } {
  const t = flight.durationMs > 0 ? (nowMs - flight.startMs) / flight.durationMs : 1;
  if (t >= 1) {
    return { pose: normalised(flight.to), done: true };
  }
  const { from, to } = flight;
  const part = easeInOut(t);
  const pose = normalised({
    eye: mix(from.eye, to.eye, part),
    headingDeg: from.headingDeg + shortTurn(from.headingDeg, to.headingDeg) * part,
    pitchDeg: from.pitchDeg + (to.pitchDeg - from.pitchDeg) * part,
    fovDeg: from.fovDeg + (to.fovDeg - from.fovDeg) * part,
  });
  return { pose, done: false };
}
