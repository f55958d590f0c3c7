import { create } from "@bufbuild/protobuf";
import { describe, expect, it } from "vitest";
import { CameraSchema, PanoramaSchema } from "../gen/flaneur/v1/panorama_pb";
import { quarterTurns } from "./upright";

/** Looks along y of a rig that stands upright; then rolled about its axis. */
const ROWS = {
  upright: [1, 0, 0, 0, 0, -1, 0, 1, 0],
  upsideDown: [-1, 0, 0, 0, 0, 1, 0, 1, 0],
  // Its right side is up: x of the camera is z of the rig.
  rightSideUp: [0, 0, 1, 1, 0, 0, 0, 1, 0],
  leftSideUp: [0, 0, -1, -1, 0, 0, 0, 1, 0],
};

describe("a photograph", () => {
  const panorama = create(PanoramaSchema, { worldFromRig: { rows: [1, 0, 0, 0, 1, 0, 0, 0, 1] } });
  const turns = (rows: number[]) =>
    quarterTurns(panorama, create(CameraSchema, { camFromRig: { rows } }));

  it("is shown with the sky on top", () => {
    expect(turns(ROWS.upright)).toBe(0);
    expect(turns(ROWS.upsideDown)).toBe(2);
    // What is on its right has to come to the top: three quarters clockwise.
    expect(turns(ROWS.rightSideUp)).toBe(3);
    expect(turns(ROWS.leftSideUp)).toBe(1);
  });

  it("straight up or down is shown as it is", () => {
    expect(turns([1, 0, 0, 0, 1, 0, 0, 0, 1])).toBe(0);
  });
});
