import { normalised, type Pose } from "../view/pose";
import { isLayer, type Layer } from "./layer";

/** What a link says. */
export interface LinkState {
  readonly scene: string | undefined;
  readonly pose: Pose | undefined;
  /** It says a place, but none where anyone can stand. */
  readonly misplaced: boolean;
  readonly layer: Layer;
}

/** No CRS has places beyond that, metres. */
const FARTHEST_M = 1e9;

export const DEFAULT_FOV_DEG = 65;

/** Reads a link's query, as in `?scene=street&at=651507.5,6861077,44.6&look=39,2,65`. */
export function readLink(search: string): LinkState {
  const query = new URLSearchParams(search);
  const layer = query.get("layer") ?? "";
  const pose = readPose(query);
  return {
    scene: query.get("scene") || undefined,
    pose,
    misplaced: query.has("at") && !pose,
    layer: isLayer(layer) ? layer : "hybrid",
  };
}

/** The pose that a link to it says: places to a millimetre, angles to a hundredth of a degree. */
export function atRest(pose: Pose): Pose {
  const [x, y, z] = pose.eye;
  return normalised({
    eye: [rounded(x, 3), rounded(y, 3), rounded(z, 3)],
    headingDeg: rounded(pose.headingDeg, 2),
    pitchDeg: rounded(pose.pitchDeg, 2),
    fovDeg: rounded(pose.fovDeg, 2),
  });
}

/** The query that `readLink` reads. */
export function writeLink(scene: string, pose: Pose, layer: Layer): string {
  const { eye, headingDeg, pitchDeg, fovDeg } = atRest(pose);
  const parts = [
    `scene=${encodeURIComponent(scene)}`,
    `at=${eye.join(",")}`,
    `look=${[headingDeg, pitchDeg, fovDeg].join(",")}`,
  ];
  if (layer !== "hybrid") {
    parts.push(`layer=${layer}`);
  }
  return `?${parts.join("&")}`;
}

function rounded(value: number, digits: number): number {
  return Number(value.toFixed(digits));
}

function readPose(query: URLSearchParams): Pose | undefined {
  const at = readNumbers(query.get("at"));
  if (at.some((value) => Math.abs(value) > FARTHEST_M)) {
    return undefined;
  }
  // Who says only where to stand looks north.
  const [headingDeg = 0, pitchDeg = 0, fovDeg = DEFAULT_FOV_DEG] = readNumbers(query.get("look"));
  const [x, y, z] = at;
  if (x === undefined || y === undefined || z === undefined) {
    return undefined;
  }
  return normalised({ eye: [x, y, z], headingDeg, pitchDeg, fovDeg });
}

/** Up to three numbers; none where one of them is none. */
function readNumbers(text: string | null): number[] {
  const numbers = (text ?? "").split(",").map((part) => (part.trim() ? Number(part) : Number.NaN));
  return numbers.length <= 3 && numbers.every(Number.isFinite) ? numbers : [];
}
