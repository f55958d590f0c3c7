import { create } from "@bufbuild/protobuf";
import { describe, expect, it } from "vitest";
import { FootprintSchema } from "../gen/flaneur/v1/footprint_pb";
import { inside, outlinesOf } from "./buildings";

describe("an outline", () => {
  it("has an inside, without its holes", () => {
    const footprint = create(FootprintSchema, {
      polygons: [
        {
          rings: [
            { coordinates: [0, 0, 10, 0, 10, 10, 0, 10] },
            { coordinates: [4, 4, 6, 4, 6, 6, 4, 6] },
          ],
        },
      ],
    });
    const [outline] = outlinesOf(footprint);
    const within = (x: number, y: number) => outline && inside(outline, x, y);
    expect(within(2, 2)).toBe(true);
    expect(within(5, 5)).toBe(false);
    expect(within(11, 5)).toBe(false);
    expect(within(-1, 5)).toBe(false);
  });

  it("of nothing contains nothing", () => {
    expect(inside([], 0, 0)).toBe(false);
    expect(inside([[]], 0, 0)).toBe(false);
  });
});
