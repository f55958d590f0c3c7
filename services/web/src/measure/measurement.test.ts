import { create } from "@bufbuild/protobuf";
import { describe, expect, it } from "vitest";
import { PlaceSchema } from "../gen/flaneur/v1/render_pb";
import { coordinates, measure, metres, plusMinus, signedMetres } from "./measurement";

function place(x: number, y: number, z: number, uncertaintyM: number) {
  return create(PlaceSchema, { position: { x, y, z }, uncertaintyM });
}

describe("a measurement", () => {
  it("has a length, its parts, and how sure they are", () => {
    const from = place(651_000, 6_861_000, 40, 0.03);
    const to = place(651_003, 6_861_004, 28, 0.04);
    const result = measure(from, to);
    expect(result).toEqual({ distance: 13, horizontal: 5, vertical: -12, uncertainty: 0.05 });
    expect(measure(from, place(0, 0, 0, 0)).uncertainty).toBeUndefined();
  });

  it("is written to the millimetre", () => {
    expect(metres(1.23456)).toBe("1.235 m");
    expect(signedMetres(-0.5)).toBe("−0.500 m");
    expect(signedMetres(0.5)).toBe("+0.500 m");
    expect(coordinates([651_507.5, 6_861_077.12345, -4])).toBe("651507.500, 6861077.123, -4.000");
    expect([0.012, 0.25, 2.345].map(plusMinus)).toEqual(["± 12 mm", "± 25 cm", "± 2.3 m"]);
  });
});
