import { describe, expect, it } from "vitest";
import { farthestView, isNear, open } from "./start";

/** A street from west to east, 20 m wide, with its end 40 m to the east and 60 m to the west. */
const STREET = {
  contain: (x: number, y: number) => Math.abs(y - 30) > 10 || x > 40 || x < -60,
};

describe("where a visit begins", () => {
  it("is in the open, near the middle", () => {
    const [x, y] = open([0, 0, 0], STREET);
    expect(Math.abs(y - 30)).toBeLessThanOrEqual(2);
    expect(Math.hypot(x, y)).toBeLessThan(36);
    expect(open([5, 31, 0], { contain: () => false })).toEqual([5, 31]);
  });

  it("is nearer to the walls where it is narrow, and the middle where all is built up", () => {
    const alley = { contain: (x: number, _y: number) => Math.abs(x - 8) > 3 };
    const [x] = open([0, 0, 0], alley);
    expect(Math.abs(x - 8)).toBeLessThanOrEqual(1);
    expect(open([1, 2, 3], { contain: () => true })).toEqual([1, 2]);
  });

  it("looks along the street", () => {
    expect(farthestView(0, 30, STREET)).toBe(270);
    expect(farthestView(-50, 30, STREET)).toBe(90);
  });
});

describe("where a link leads", () => {
  const corner = (x: number, y: number, z: number) =>
    ({ $typeName: "flaneur.v1.Point3", x, y, z }) as const;
  const bounds = {
    $typeName: "flaneur.v1.Bounds3",
    min: corner(650_000, 6_860_000, 30),
    max: corner(651_000, 6_861_000, 90),
  } as const;

  it("is in the scene, or in its sight", () => {
    expect(isNear({ bounds }, [650_500, 6_860_500, 40])).toBe(true);
    expect(isNear({ bounds }, [660_000, 6_860_500, 2000])).toBe(true);
    expect(isNear({ bounds }, [700_000, 6_860_500, 40])).toBe(false);
    expect(isNear({ bounds }, [650_500, 6_860_500, -1e6])).toBe(false);
    expect(isNear({ bounds }, [1, 2, 3])).toBe(false);
  });
});
