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

/** The query that `readLink` reads, places to a millimetre and angles to a hundredth of a degree. */
export function writeLink(scene: string, pose: Pose, layer: Layer): string {
  const numbers = (values: readonly number[], digits: number) =>
    values.map((value) => Number(value.toFixed(digits))).join(",");
  const parts = [
    `scene=${encodeURIComponent(scene)}`,
    `at=${numbers(pose.eye, 3)}`,
    `look=${numbers([pose.headingDeg, pose.pitchDeg, pose.fovDeg], 2)}`,
  ];
  if (layer !== "hybrid") {
    parts.push(`layer=${layer}`);
  }
  return `?${parts.join("&")}`;
}

function readPose(query: URLSearchParams): Pose | undefined {
  const at = readNumbers(query.get("at"));
  if (at.some((value) => Math.abs(value) > FARTHEST_M)) {
    return undefined;
  }
  const [headingDeg, pitchDeg = 0, fovDeg = DEFAULT_FOV_DEG] = readNumbers(query.get("look"));
  const [x, y, z] = at;
  if (x === undefined || y === undefined || z === undefined || headingDeg === undefined) {
    return undefined;
  }
  return normalised({ eye: [x, y, z], headingDeg, pitchDeg, fovDeg });
}

/** Up to three numbers; none where one of them is none. */
function readNumbers(text: string | null): number[] {
  const numbers = (text ?? "").split(",").map((part) => (part.trim() ? Number(part) : Number.NaN));
  return numbers.length <= 3 && numbers.every(Number.isFinite) ? numbers : [];
}
