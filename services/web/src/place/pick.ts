import type { Clients } from "../api/clients";
import type { ScreenPoint } from "../controls/steering";
import { MeshSurface_Class, type Place } from "../gen/flaneur/v1/render_pb";
import type { Vector3 } from "../geometry/vector";
import { pictureOf, type Screen, WHOLE } from "../picture/request";
import type { Layer } from "../state/layer";
import { viewMessage } from "../view/message";
import type { Pose } from "../view/pose";

/** No answer for so long is none, milliseconds. */
const PATIENCE_MS = 10_000;

/** What was surveyed at a place of the screen; undefined where nothing was. */
export async function pick(
  render: Clients["render"],
  request: {
    readonly scene: string;
    readonly pose: Pose;
    readonly screen: Screen;
    readonly layer: Layer;
    readonly at: ScreenPoint;
    readonly photographs: boolean;
    /** Those of the session. */
    readonly headers: Record<string, string>;
  },
): Promise<Place | undefined> {
  const { scene, pose, screen, layer, at, photographs, headers } = request;
  const camera = pictureOf(pose, screen, WHOLE);
  const pixel = {
    x: (at[0] * camera.width) / screen.width,
    y: (at[1] * camera.height) / screen.height,
  };
  const view = viewMessage(camera, layer);
  const options = { headers, timeoutMs: PATIENCE_MS };
  const { place } = await render.pick({ scene, view, pixel, photographs }, options);
  return place?.position ? place : undefined;
}

export function positionOf(place: Place): Vector3 {
  const { x, y, z } = place.position ?? { x: Number.NaN, y: Number.NaN, z: Number.NaN };
  return [x, y, z];
}

/** What one does at a place: go there, face it, or look at it. */
export type PlaceKind = "ground" | "wall" | "other";

/** Higher above the terrain it is not the ground, metres. */
const STEP_M = 0.4;
/** LAS: ground, and road surface. */
const GROUND_CLASSES = new Set([2, 11]);

/** Which of them a place is, where `ground` is the terrain's height there, if it is known. */
export function kindOf(place: Place, ground: number | undefined): PlaceKind {
  const [, , z] = positionOf(place);
  const { surface } = place;
  if (surface.case === "mesh") {
    switch (surface.value.class) {
      case MeshSurface_Class.GROUND:
        return "ground";
      case MeshSurface_Class.WALL:
        return "wall";
      default:
        return "other";
    }
  }
  const isGround = surface.case === "point" && GROUND_CLASSES.has(surface.value.classification);
  if (isGround || (ground !== undefined && Math.abs(z - ground) < STEP_M)) {
    return "ground";
  }
  return Math.abs(place.normal?.z ?? 1) < 0.4 ? "wall" : "other";
}
