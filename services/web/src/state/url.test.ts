import { describe, expect, it } from "vitest";
import type { Pose } from "../view/pose";
import { atRest, readLink, writeLink } from "./url";

const POSE: Pose = {
  eye: [651_507.5004, 6_861_077.125, -4.6],
  headingDeg: 39.126,
  pitchDeg: -2.5,
  fovDeg: 65,
};

describe("links", () => {
  it("come back as they were written, to a millimetre and a hundredth of a degree", () => {
    const link = writeLink("rue de l'été & co", POSE, "uncertainty");
    expect(readLink(link)).toEqual({
      scene: "rue de l'été & co",
      pose: { ...POSE, eye: [651_507.5, 6_861_077.125, -4.6], headingDeg: 39.13 },
      misplaced: false,
      layer: "uncertainty",
    });
    expect(readLink(writeLink("a", POSE, "hybrid")).layer).toBe("hybrid");
  });

  it("are readable, and written the same again", () => {
    const link = writeLink("street", POSE, "hybrid");
    expect(link).toBe("?scene=street&at=651507.5,6861077.125,-4.6&look=39.13,-2.5,65");
    const { pose } = readLink(link);
    expect(pose && writeLink("street", pose, "hybrid")).toBe(link);
  });

  it("say the very pose at which one comes to rest", () => {
    const pose = atRest({
      ...POSE,
      eye: [1.00049, -2.0006, 3],
      headingDeg: 359.997,
      fovDeg: 64.999,
    });
    expect(pose).toMatchObject({ eye: [1, -2.001, 3], headingDeg: 0, fovDeg: 65 });
    expect(readLink(writeLink("a", pose, "hybrid")).pose).toEqual(pose);
    expect(atRest(pose)).toEqual(pose);
  });

  it("that say nothing sensible say nothing", () => {
    const nothing = { scene: undefined, pose: undefined, misplaced: false, layer: "hybrid" };
    for (const query of ["", "?scene=&layer=constructor", "?look=3"]) {
      expect(readLink(query)).toEqual(nothing);
    }
    for (const at of ["1,2", "1,2,x", "1e300,2,3", "1,-1e10,3", "1,2,3e9", ""]) {
      expect(readLink(`?at=${at}&look=0`)).toEqual({ ...nothing, misplaced: true });
    }
    expect(readLink("?at=1,2,3,4&look=0").pose).toBeUndefined();
    expect(readLink("?at=1,,3&look=0").pose).toBeUndefined();
    expect(readLink("?at=1,2,Infinity&look=0").pose).toBeUndefined();
  });

  it("keep angles within what can be looked at", () => {
    expect(readLink("?at=1,2,3&look=-10,120,500").pose).toEqual({
      eye: [1, 2, 3],
      headingDeg: 350,
      pitchDeg: 89,
      fovDeg: 110,
    });
    expect(readLink("?at=1,2,3&look=5").pose).toMatchObject({ pitchDeg: 0, fovDeg: 65 });
    for (const link of ["?at=1,2,3", "?at=1,2,3&look=abc"]) {
      expect(readLink(link)).toMatchObject({
        misplaced: false,
        pose: { headingDeg: 0, fovDeg: 65 },
      });
    }
  });
});
