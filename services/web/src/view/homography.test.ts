import { describe, expect, it } from "vitest";
import { add, scale, type Vector3 } from "../geometry/vector";
import { covers, cssTransform, homography, mapped } from "./homography";
import { type Pinhole, project, rayOf } from "./pinhole";

const EYE: Vector3 = [651_507.5, 6_861_077.2, 44.6];

function camera(
  eye: Vector3,
  headingDeg: number,
  pitchDeg: number,
  fovDeg: number,
  width = 1024,
  height = 512,
): Pinhole {
  return { pose: { eye, headingDeg, pitchDeg, fovDeg }, width, height };
}

describe("homography", () => {
  it("moves pixels as projected places move, between two cameras with one eye", () => {
    const from = camera(EYE, 350, -12, 65);
    const to = camera(EYE, 25, 31, 42, 360, 740);
    const h = homography(to, from, 15);
    let compared = 0;
    for (let u = 10; u < 1024; u += 101) {
      for (let v = 10; v < 512; v += 101) {
        // The depth does not matter.
        const place = add(EYE, scale(rayOf(from, [u, v]), 3 + ((u * v) % 90)));
        const expected = project(to, place);
        if (!expected) {
          continue;
        }
        const shown = mapped(h, [u, v]);
        // Far from the picture's middle a pixel is a large angle, and doubles of 10⁷ m are coarse.
        const tolerance = 1e-5 * Math.max(1, Math.hypot(...expected));
        expect(Math.abs((shown?.[0] ?? Number.NaN) - expected[0])).toBeLessThan(tolerance);
        expect(Math.abs((shown?.[1] ?? Number.NaN) - expected[1])).toBeLessThan(tolerance);
        compared += 1;
      }
    }
    expect(compared).toBeGreaterThan(40);
  });

  it("is exact on its plane where the eye went on", () => {
    const from = camera(EYE, 39, 5, 65);
    const to = camera(add(EYE, [0.8, 1.1, 0.1]), 51, -8, 70);
    const h = homography(to, from, 15);
    // On the upright plane 15 m before the eye, across where `from` looks.
    const heading = (39 * Math.PI) / 180;
    const ahead: Vector3 = [Math.sin(heading), Math.cos(heading), 0];
    const across: Vector3 = [ahead[1], -ahead[0], 0];
    for (const [x, z] of [
      [-3, -2],
      [4, 1],
      [0, 3],
    ] as const) {
      const place = add(add(EYE, scale(ahead, 15)), add(scale(across, x), [0, 0, z]));
      const pixel = project(from, place);
      const expected = project(to, place);
      const shown = pixel && mapped(h, pixel);
      expect(shown?.[0]).toBeCloseTo(expected?.[0] ?? Number.NaN, 4);
      expect(shown?.[1]).toBeCloseTo(expected?.[1] ?? Number.NaN, 4);
    }
  });

  it("knows when a picture fills another", () => {
    const whole = camera(EYE, 0, 0, 65);
    const narrow = camera(EYE, 0, 0, 60);
    const turned = camera(EYE, 8, 0, 65);
    const behind = camera(EYE, 180, 0, 65);
    const filled = (from: Pinhole, to: Pinhole) => covers(homography(to, from, 15), from, to);
    expect(filled(whole, whole)).toBe(true);
    expect(filled(whole, narrow)).toBe(true);
    expect(filled(narrow, whole)).toBe(false);
    expect(filled(whole, turned)).toBe(false);
    expect(filled(whole, behind)).toBe(false);
  });

  it("is written down by columns", () => {
    const css = cssTransform([
      [2, 4, 6],
      [8, 10, 12],
      [0, 1, 2],
    ]);
    expect(css).toBe("matrix3d(2,8,0,0,4,10,0,1,0,0,1,0,6,12,0,2)");
  });
});
