import type { ScreenPoint } from "../controls/steering";

export type Side = "left" | "right";

/** A box in CSS pixels. */
export type Box = Pick<DOMRect, "left" | "top" | "right" | "bottom">;

/**
 * On which side a panel hides as little as possible of what was clicked; the last place counts most,
 * and where it makes no difference the panel stays.
 *
 * @param box of the panel where it is now; on the other side it lies mirrored
 * @param width of the page, CSS pixels
 */
export function sideFor(box: Box, width: number, places: readonly ScreenPoint[], now: Side): Side {
  const other: Box = { ...box, left: width - box.right, right: width - box.left };
  const hidden = (by: Box) =>
    places.reduce((sum, place, index) => sum + (isIn(by, place) ? 1 + index : 0), 0);
  if (hidden(other) >= hidden(box)) {
    return now;
  }
  return now === "left" ? "right" : "left";
}

/** Marks are larger than their places, CSS pixels. */
const MARGIN_PX = 12;

function isIn(box: Box, [x, y]: ScreenPoint): boolean {
  return (
    x > box.left - MARGIN_PX &&
    x < box.right + MARGIN_PX &&
    y > box.top - MARGIN_PX &&
    y < box.bottom + MARGIN_PX
  );
}
