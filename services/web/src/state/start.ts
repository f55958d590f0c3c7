import type { Scene } from "../gen/flaneur/v1/scene_pb";
import type { Vector3 } from "../geometry/vector";
import type { Terrain } from "../ground/terrain";
import type { Buildings } from "../map/buildings";
import { type Catalogue, placeOf } from "../photographs/catalogue";
import { direction, normalised, type Pose } from "../view/pose";
import { DEFAULT_FOV_DEG } from "./url";

/** Eyes are so far above the ground, metres. */
export const EYE_HEIGHT_M = 1.6;

/** On narrow screens more is shown from bottom to top, so that something is seen from side to side. */
export function firstFovDeg(width: number, height: number): number {
  return width < height ? 80 : DEFAULT_FOV_DEG;
}

/**
 * Where a visit begins that no link began: at the photograph nearest to the scene's middle, looking
 * where it looks. Without photographs in the open nearest to the middle, looking north.
 */
export async function firstPose(
  scene: Scene,
  catalogue: Catalogue,
  buildings: Buildings,
  terrain: Terrain,
  fovDeg: number,
): Promise<Pose> {
  const middle: Vector3 = [scene.origin?.x ?? 0, scene.origin?.y ?? 0, scene.origin?.z ?? 0];
  const panorama = catalogue.nearest(middle);
  const rows = panorama?.worldFromRig?.rows ?? [];
  if (panorama) {
    // The rig's y axis looks forward.
    const [x = 0, y = 1] = [rows[1], rows[4]];
    const { headingDeg } = direction([x, y, 0]);
    return normalised({ eye: placeOf(panorama), headingDeg, pitchDeg: 0, fovDeg });
  }
  const [x, y] = open(middle, buildings);
  await terrain.around(x, y);
  const eye: Vector3 = [x, y, (terrain.height(x, y) ?? middle[2]) + EYE_HEIGHT_M];
  return { eye, headingDeg: 0, pitchDeg: 0, fovDeg };
}

/** The place nearest to the middle, on growing rings, that is in no building and 3 m off any. */
function open(middle: Vector3, buildings: Buildings): readonly [number, number] {
  const around: [number, number][] = [
    [0, 0],
    [3, 0],
    [-3, 0],
    [0, 3],
    [0, -3],
  ];
  const clear = (x: number, y: number) =>
    around.every(([dx, dy]) => !buildings.contain(x + dx, y + dy));
  for (let radius = 0; radius <= 100; radius += 4) {
    const steps = Math.max(1, Math.round(radius * 1.5));
    for (let step = 0; step < steps; step += 1) {
      const angle = (2 * Math.PI * step) / steps;
      const x = middle[0] + radius * Math.sin(angle);
      const y = middle[1] + radius * Math.cos(angle);
      if (clear(x, y)) {
        return [x, y];
      }
    }
  }
  return [middle[0], middle[1]];
}
