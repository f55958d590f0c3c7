import { focalLength, fovOf, type Pinhole } from "../view/pinhole";
import type { Pose } from "../view/pose";

/** The window that a picture is to fill. */
export interface Screen {
  /** CSS pixels. */
  readonly width: number;
  readonly height: number;
  /** Device pixels for a CSS pixel. */
  readonly density: number;
}

/** How much of a picture is asked for. */
export interface Effort {
  /** Most pixels. */
  readonly pixels: number;
  /** How much wider and higher than the screen, so that there is something beside it: >= 1. */
  readonly margin: number;
}

/** The best picture: all that a large screen has; the server makes it smaller where it must. */
export const WHOLE: Effort = { pixels: 1 << 21, margin: 1 };

/**
 * The picture to ask for: of the screen's shape with its margin, with the screen's own pixels
 * where they are not too many.
 */
export function pictureOf(pose: Pose, screen: Screen, effort: Effort): Pinhole {
  const width = Math.max(screen.width, 1) * effort.margin;
  const height = Math.max(screen.height, 1) * effort.margin;
  const fine = Math.min(screen.density, Math.sqrt(effort.pixels / (width * height)));
  // Rounded down, so that the product keeps within what was asked for.
  const size = (length: number) => Math.max(Math.floor(length * fine + 1e-9), 1);
  const pixelHeight = size(height);
  const focal = focalLength({ pose, width: screen.width, height: Math.max(screen.height, 1) });
  const fovDeg = Math.min(fovOf(focal * fine, pixelHeight), 160);
  return { pose: { ...pose, fovDeg }, width: size(width), height: pixelHeight };
}
