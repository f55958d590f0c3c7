import { create } from "@bufbuild/protobuf";
import { describe, expect, it } from "vitest";
import { MeshSurface_Class, PlaceSchema } from "../gen/flaneur/v1/render_pb";
import type { Pose } from "../view/pose";
import { facing, standingOn } from "./destination";
import { kindOf } from "./pick";

const POSE: Pose = { eye: [0, 0, 11.6], headingDeg: 45, pitchDeg: -20, fovDeg: 65 };

type Point = { x: number; y: number; z: number };
type Surface =
  | { case: "mesh"; value: { class: MeshSurface_Class } }
  | { case: "point"; value: { classification: number } };

function place(fields: { position?: Point; normal?: Point; surface?: Surface }) {
  return create(PlaceSchema, { position: { x: 0, y: 8, z: 12 }, ...fields });
}

function mesh(value: MeshSurface_Class) {
  return { surface: { case: "mesh" as const, value: { class: value } } };
}

describe("a clicked place", () => {
  it("is what the survey says it is", () => {
    expect(kindOf(place(mesh(MeshSurface_Class.GROUND)), undefined)).toBe("ground");
    expect(kindOf(place(mesh(MeshSurface_Class.WALL)), 12)).toBe("wall");
    expect(kindOf(place(mesh(MeshSurface_Class.ROOF)), 12)).toBe("other");
    const point = (classification: number, z: number) =>
      place({
        normal: { x: 0, y: -1, z },
        surface: { case: "point", value: { classification } },
      });
    expect(kindOf(point(2, 0), undefined)).toBe("ground");
    expect(kindOf(point(6, 0), 10)).toBe("wall");
    expect(kindOf(point(1, 0), 11.9)).toBe("ground");
    expect(kindOf(point(5, 0.9), 4)).toBe("other");
  });

  it("on the ground is stood on, 1.6 m below the eye", () => {
    expect(standingOn(POSE, place({}))).toEqual({ ...POSE, eye: [0, 8, 13.6] });
  });

  it("on a wall is faced: straight before it, as far as one was", () => {
    const wall = place({ position: { x: 5, y: 8, z: 11.6 }, normal: { x: 0, y: -1, z: 0 } });
    const pose = facing(POSE, wall, () => 10);
    expect(pose.eye).toEqual([5, 0, 11.6]);
    expect(pose.headingDeg).toBeCloseTo(0);
    expect(pose.pitchDeg).toBeCloseTo(0);
  });

  it("on a wall is faced from 3 to 10 metres, on the terrain there", () => {
    const slope = (_x: number, y: number) => 10 + 0.1 * y;
    const near = place({ position: { x: 0, y: 1, z: 11 }, normal: { x: 0, y: -1, z: 0 } });
    expect(facing(POSE, near, slope).eye).toEqual([0, -2, expect.closeTo(11.4, 9)]);
    const far = place({ position: { x: 0, y: 20, z: 11 }, normal: { x: 0, y: -1, z: 0 } });
    expect(facing(POSE, far, slope).eye).toEqual([0, 10, expect.closeTo(12.6, 9)]);
  });

  it("far away is looked at from where one is", () => {
    const far = place({ position: { x: 50, y: 0, z: 90 }, normal: { x: -1, y: 0, z: 0 } });
    const pose = facing(POSE, far, () => 10);
    expect(pose.eye).toBe(POSE.eye);
    expect(pose.headingDeg).toBeCloseTo(90);
    expect(pose.pitchDeg).toBe(30);
  });
});
