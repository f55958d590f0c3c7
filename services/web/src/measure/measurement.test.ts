import { create } from "@bufbuild/protobuf";
import { describe, expect, it } from "vitest";
import { type Place, PlaceSchema } from "../gen/flaneur/v1/render_pb";
import {
  coordinates,
  geographic,
  measure,
  metres,
  plusMinus,
  pointed,
  signedMetres,
} from "./measurement";

function place(x: number, y: number, z: number, uncertaintyM: number) {
  return create(PlaceSchema, { position: { x, y, z }, uncertaintyM });
}

describe("a measurement", () => {
  it("has a length, its parts, and how sure they are", () => {
    const from = { place: place(651_000, 6_861_000, 40, 0.02), off: 0.03 };
    const to = { place: place(651_003, 6_861_004, 28, 0.02), off: 0.04 };
    const result = measure(from, to);
    expect(result).toEqual({ distance: 13, horizontal: 5, vertical: -12, uncertainty: 0.05 });
    const unknown = { place: place(0, 0, 0, 0), off: undefined };
    expect(measure(from, unknown).uncertainty).toBeUndefined();
  });

  it("is no surer than the clicks, and less sure of what is seen askew", () => {
    // A wall 20 m ahead, of which a pixel is 2 cm; seen askew it is more, but never without end.
    const wall = { ...place(0, 20, 0, 0.03), normal: { x: 0, y: -1, z: 0 } } as Place;
    const across = Math.hypot(0.03, 0.02);
    expect(pointed(wall, [0, 0, 0], 1000).off).toBeCloseTo(across);
    // A road is surveyed to 3 cm of height: what one sees on it at a slope of 1 in 5 may be five times as far off.
    const road = { ...place(0, 20, 0, 0.03), normal: { x: 0, y: -0.2, z: 0.98 } } as Place;
    expect(pointed(road, [0, 0, 0], 1000).off).toBeCloseTo(5 * across);
    const askew = { ...wall, normal: { x: 0.99995, y: -0.01, z: 0 } } as Place;
    expect(pointed(askew, [0, 0, 0], 1000).off).toBeCloseTo(10 * across);
    const unknown = { ...wall, uncertaintyM: 0 } as Place;
    expect(pointed(unknown, [0, 0, 0], 1000).off).toBeUndefined();
  });

  it("says no more digits than it is sure of", () => {
    expect(geographic(48.123456789, 2.1, 0.5)).toBe("48.123457, 2.100000");
    expect(geographic(48.123456789, 2.1, 0.03)).toBe("48.1234568, 2.1000000");
    expect(geographic(48.123456789, 2.1, 0)).toBe("48.1234568, 2.1000000");
    expect(metres(1.23456, 0.5)).toBe("1.23 m");
    expect(coordinates([1, 2, 4.56789], 0.25)).toBe("1.00, 2.00, 4.57");
    expect(signedMetres(-0.5, 0.5)).toBe("−0.50 m");
  });

  it("is written to the millimetre where the survey is as sure", () => {
    expect(metres(1.23456)).toBe("1.235 m");
    expect(signedMetres(-0.5)).toBe("−0.500 m");
    expect(signedMetres(0.5)).toBe("+0.500 m");
    expect(coordinates([651_507.5, 6_861_077.12345, -4])).toBe("651507.500, 6861077.123, -4.000");
    expect([0.012, 0.25, 2.345].map(plusMinus)).toEqual(["± 12 mm", "± 25 cm", "± 2.3 m"]);
  });
});
