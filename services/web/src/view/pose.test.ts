import { describe, expect, it } from "vitest";
import { fullTurn, shortTurn } from "../geometry/angles";
import { apply } from "../geometry/matrix";
import type { Vector3 } from "../geometry/vector";
import { focalLength, fovOf, type Pinhole, project, rayOf } from "./pinhole";
import { camFromWorld, direction, lookingAt, normalised, type Pose } from "./pose";

const POSE: Pose = { eye: [100, 200, 10], headingDeg: 0, pitchDeg: 0, fovDeg: 90 };

describe("pose", () => {
  it("looks north at heading 0, east at 90, and up with its pitch", () => {
    const forward = (pose: Pose) => camFromWorld(pose)[2];
    expect(forward(POSE)).toEqual([0, 1, 0]);
    expect(forward({ ...POSE, headingDeg: 90 })[0]).toBeCloseTo(1);
    expect(forward({ ...POSE, pitchDeg: 30 })[2]).toBeCloseTo(0.5);
  });

  it("has axes that are a rotation", () => {
    const [x, y, z] = camFromWorld({ ...POSE, headingDeg: 77, pitchDeg: -33 });
    const cross: Vector3 = [
      x[1] * y[2] - x[2] * y[1],
      x[2] * y[0] - x[0] * y[2],
      x[0] * y[1] - x[1] * y[0],
    ];
    cross.forEach((value, axis) => {
      expect(value).toBeCloseTo(z[axis as 0 | 1 | 2], 12);
    });
    const up = apply(camFromWorld(POSE), [0, 0, 1]);
    expect(up).toEqual([0, -1, 0]);
  });

  it("turns towards a place", () => {
    const turned = lookingAt(POSE, [110, 210, 10 + Math.hypot(10, 10)]);
    expect(turned.headingDeg).toBeCloseTo(45);
    expect(turned.pitchDeg).toBeCloseTo(45);
    expect(direction([-1, 0, 0]).headingDeg).toBeCloseTo(270);
  });

  it("keeps its angles in their ranges", () => {
    const pose = normalised({ ...POSE, headingDeg: -1e-20, pitchDeg: 95, fovDeg: 0 });
    expect(pose).toEqual({ ...POSE, headingDeg: 0, pitchDeg: 89, fovDeg: 5 });
    expect(fullTurn(-90)).toBe(270);
    expect(shortTurn(350, 10)).toBe(20);
    expect(shortTurn(10, 350)).toBe(-20);
  });
});

describe("pinhole", () => {
  const camera: Pinhole = {
    pose: { eye: [651_507.5, 6_861_077, 44.6], headingDeg: 211, pitchDeg: -7, fovDeg: 65 },
    width: 801,
    height: 513,
  };

  it("projects what lies on the ray of a pixel onto that pixel", () => {
    const ray = rayOf(camera, [77, 400]);
    const place = camera.pose.eye.map((value, axis) => value + 20 * (ray[axis] ?? 0));
    const [u, v] = project(camera, place as unknown as Vector3) ?? [];
    expect(u).toBeCloseTo(77, 5);
    expect(v).toBeCloseTo(400, 5);
  });

  it("projects nothing from behind", () => {
    const ray = rayOf(camera, [400, 250]);
    const place = camera.pose.eye.map((value, axis) => value - 20 * (ray[axis] ?? 0));
    expect(project(camera, place as unknown as Vector3)).toBeUndefined();
  });

  it("shows its field of view from bottom to top", () => {
    expect(focalLength({ ...camera, pose: { ...camera.pose, fovDeg: 90 } })).toBeCloseTo(513 / 2);
    expect(fovOf(focalLength(camera), 513)).toBeCloseTo(65);
  });
});
