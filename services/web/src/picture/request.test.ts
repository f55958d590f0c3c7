import { create } from "@bufbuild/protobuf";
import { describe, expect, it } from "vitest";
import { FrameSchema } from "../gen/flaneur/v1/render_pb";
import { covers, homography } from "../view/homography";
import { focalLength } from "../view/pinhole";
import type { Pose } from "../view/pose";
import { Pace } from "./pace";
import { pictureOf, WHOLE } from "./request";

const POSE: Pose = { eye: [1, 2, 3], headingDeg: 10, pitchDeg: 0, fovDeg: 65 };

describe("what is asked for", () => {
  it("is the screen's own pixels where they are not too many", () => {
    const picture = pictureOf(POSE, { width: 800, height: 600, density: 1 }, WHOLE);
    expect(picture).toEqual({ pose: POSE, width: 800, height: 600 });
    const large = pictureOf(POSE, { width: 1920, height: 1080, density: 1 }, WHOLE);
    expect(large).toEqual({ pose: POSE, width: 1920, height: 1080 });
  });

  it("never has more pixels than asked for, and keeps the scale of the screen", () => {
    for (const [width, height, density] of [
      [3840, 2160, 1],
      [360, 740, 3],
      [1279, 719, 2],
      [1, 1, 1],
      [0, 0, 1],
    ] as const) {
      for (const margin of [1, 1.2]) {
        const picture = pictureOf(POSE, { width, height, density }, { pixels: 1 << 19, margin });
        expect(picture.width * picture.height).toBeLessThanOrEqual(1 << 19);
        expect(Math.min(picture.width, picture.height)).toBeGreaterThanOrEqual(1);
        expect(picture.pose.fovDeg).toBeLessThanOrEqual(160);
      }
    }
  });

  it("fills the screen with its margin", () => {
    const screen = { width: 1200, height: 700, density: 1 };
    const picture = pictureOf(POSE, screen, { pixels: 1 << 18, margin: 1.2 });
    const shown = { pose: POSE, ...screen };
    expect(covers(homography(shown, picture, 15), picture, shown)).toBe(true);
    const turned = { ...shown, pose: { ...POSE, headingDeg: 14 } };
    expect(covers(homography(turned, picture, 15), picture, turned)).toBe(true);
    const scale = focalLength(picture) / focalLength(shown);
    expect(scale).toBeCloseTo(picture.width / 1.2 / 1200, 2);
  });
});

describe("the pace", () => {
  const frame = (renderMs: number, final = false) =>
    create(FrameSchema, { renderMs, encodeMs: 4, final, view: { width: 1024, height: 512 } });

  it("asks a slow server for less, and a quick one for all", () => {
    const slow = new Pace();
    const quick = new Pace();
    for (let count = 0; count < 20; count += 1) {
      slow.took(frame(160));
      quick.took(frame(4));
    }
    expect(quick.moving(false).pixels).toBe(1 << 20);
    expect(slow.moving(false).pixels).toBe(1 << 19);
    expect(slow.moving(true).margin).toBeGreaterThan(1);
  });

  it("does not mind how long final frames take", () => {
    const pace = new Pace();
    const before = pace.moving(false);
    for (let count = 0; count < 20; count += 1) {
      pace.took(frame(3000, true));
    }
    expect(pace.moving(false)).toEqual(before);
  });
});
