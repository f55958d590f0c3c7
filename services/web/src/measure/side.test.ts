import { describe, expect, it } from "vitest";
import { sideFor } from "./side";

/** On the right of a page that is 1000 wide. */
const BOX = { left: 592, top: 64, right: 988, bottom: 480 };

describe("the side of the panel", () => {
  const side = (...places: [number, number][]) => sideFor(BOX, 1000, places, "right");

  it("is the other one where the panel hides what was clicked", () => {
    expect(side([700, 200])).toBe("left");
    expect(side([700, 600])).toBe("right");
    expect(side([300, 200])).toBe("right");
    expect(sideFor({ ...BOX, left: 12, right: 408 }, 1000, [[300, 200]], "left")).toBe("right");
  });

  it("counts the mark, not the place alone", () => {
    expect(side([700, 485])).toBe("left");
  });

  it("counts the last place more than the one before, and changes for a reason only", () => {
    expect(side([300, 200], [700, 200])).toBe("left");
    expect(side([700, 200], [300, 200])).toBe("right");
    const full = { left: 8, top: 500, right: 992, bottom: 560 };
    expect(sideFor(full, 1000, [[700, 520]], "right")).toBe("right");
  });
});
