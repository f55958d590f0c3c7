import { describe, expect, it } from "vitest";
import type { Pose } from "../view/pose";
import { easeInOut, flightMs } from "./easing";
import { flight, poseAt } from "./flight";
import { slid } from "./slide";
import cases from "./slide.cases.json";
import { walked } from "./walk";

const POSE: Pose = { eye: [100, 200, 11.6], headingDeg: 350, pitchDeg: 0, fovDeg: 65 };
const STILL = { forward: 0, right: 0, turn: 0, tilt: 0, hurried: false };

/** Nothing is built. */
const NOWHERE = { contain: () => false };

describe("flights", () => {
  it("last 100 + 30 √d milliseconds", () => {
    expect(flightMs(0)).toBe(100);
    expect(flightMs(25)).toBe(250);
    expect(flightMs(-1)).toBe(100);
    const far = flight(POSE, { ...POSE, eye: [103, 204, 11.6] }, 1000, false);
    expect(far.durationMs).toBeCloseTo(100 + 30 * Math.sqrt(5));
  });

  it("start and end at rest, and never go back", () => {
    expect([easeInOut(-1), easeInOut(0), easeInOut(0.5), easeInOut(1), easeInOut(2)]).toEqual([
      0, 0, 0.5, 1, 1,
    ]);
    const slope = (t: number) => (easeInOut(t + 1e-6) - easeInOut(t - 1e-6)) / 2e-6;
    expect(slope(0)).toBeCloseTo(0, 3);
    expect(slope(1)).toBeCloseTo(0, 3);
    for (let t = 0; t < 1; t += 0.01) {
      expect(easeInOut(t + 0.01)).toBeGreaterThan(easeInOut(t));
    }
  });

  it("turn the short way and arrive exactly", () => {
    const to: Pose = { eye: [110, 200, 12], headingDeg: 10, pitchDeg: -5, fovDeg: 40 };
    const turn = flight(POSE, to, 0, false);
    const half = poseAt(turn, turn.durationMs / 2);
    expect(half.done).toBe(false);
    expect(half.pose.headingDeg).toBeCloseTo(0);
    expect(half.pose.eye[0]).toBeCloseTo(105);
    expect(poseAt(turn, turn.durationMs)).toEqual({ pose: to, done: true });
  });

  it("are over at once for people who want no motion", () => {
    const jump = flight(POSE, { ...POSE, eye: [0, 0, 0] }, 5, true);
    expect(poseAt(jump, 5).done).toBe(true);
  });
});

describe("walking", () => {
  const slope = (x: number) => 10 + 0.1 * (x - 100);

  it("goes where one looks and keeps the eye's height above the ground", () => {
    const east = { ...POSE, headingDeg: 90 };
    const pose = walked(east, { ...STILL, forward: 1 }, 2, slope, NOWHERE);
    expect(pose.eye[0]).toBeCloseTo(106);
    expect(pose.eye[1]).toBeCloseTo(200);
    expect(pose.eye[2] - slope(pose.eye[0])).toBeCloseTo(1.6);
  });

  it("is no faster askew", () => {
    const pose = walked(POSE, { ...STILL, forward: 1, right: -1 }, 1, slope, NOWHERE);
    expect(Math.hypot(pose.eye[0] - 100, pose.eye[1] - 200)).toBeCloseTo(3);
  });

  it("stays level where the ground ends", () => {
    const edge = (x: number) => (x > 103 ? undefined : 10);
    const pose = walked({ ...POSE, headingDeg: 90 }, { ...STILL, forward: 1 }, 2, edge, NOWHERE);
    expect(pose.eye[2]).toBe(11.6);
  });

  it("turns clockwise and tilts up, on the spot", () => {
    const pose = walked(POSE, { ...STILL, turn: 1, tilt: 1 }, 0.2, slope, NOWHERE);
    expect(pose.headingDeg).toBeCloseTo(5);
    expect(pose.pitchDeg).toBeCloseTo(15);
    expect(pose.eye).toBe(POSE.eye);
  });

  /** North of y = 205 all is built up. */
  const north = { contain: (_x: number, y: number) => y > 205 };
  const steps = (from: Pose, count: number) => {
    let pose = from;
    for (let step = 0; step < count; step += 1) {
      pose = walked(pose, { ...STILL, forward: 1 }, 1 / 60, slope, north);
    }
    return pose;
  };

  it("ends before a wall", () => {
    const { eye } = steps({ ...POSE, headingDeg: 0 }, 600);
    expect(eye[1]).toBeGreaterThan(204);
    expect(eye[1]).toBeLessThan(205);
    expect(Math.abs(eye[0] - 100)).toBeLessThan(1);
  });

  it("goes along a wall that is met askew", () => {
    const { eye } = steps({ ...POSE, headingDeg: 50 }, 600);
    expect(eye[1]).toBeGreaterThan(204);
    expect(eye[1]).toBeLessThan(205);
    // Ten seconds at 3 m/s, at least half of them along the wall.
    expect(eye[0]).toBeGreaterThan(113);
  });

  it("goes beside walls as the window does", () => {
    const contain = (x: number, y: number) =>
      cases.houses.some(([w = 0, s = 0, e = 0, n = 0]) => w < x && x < e && s < y && y < n);
    for (const { what, from, step, goes } of cases.steps) {
      const [x = 0, y = 0] = slid([from[0] ?? 0, from[1] ?? 0], [step[0] ?? 0, step[1] ?? 0], {
        contain,
      });
      expect(x, what).toBeCloseTo(goes[0] ?? Number.NaN, 5);
      expect(y, what).toBeCloseTo(goes[1] ?? Number.NaN, 5);
    }
  });

  it("is free for who stands inside", () => {
    const { eye } = steps({ ...POSE, eye: [100, 210, 11], headingDeg: 180 }, 600);
    expect(eye[1]).toBeCloseTo(180, 1);
  });
});
