import type { Scene } from "../gen/flaneur/v1/scene_pb";
import { radians } from "../geometry/angles";
import type { Vector3 } from "../geometry/vector";
import type { Terrain } from "../ground/terrain";
import type { Buildings } from "../map/buildings";
import type { Walls } from "../motion/slide";
import { type Catalogue, placeOf } from "../photographs/catalogue";
import { direction, normalised, type Pose } from "../view/pose";
import { DEFAULT_FOV_DEG } from "./url";

/** Eyes are so far above the ground, metres. */
export const EYE_HEIGHT_M = 1.6;

/** An open place is looked for so far, and a view is no farther, metres. */
const FARTHEST_M = 100;

/** From farther away nothing of a scene is to be seen, metres. */
const OUT_OF_SIGHT_M = 20_000;

/** Whether a place is in a scene, or near enough to see it. */
export function isNear(scene: Pick<Scene, "bounds">, place: Vector3): boolean {
  return isWithin(scene, place, OUT_OF_SIGHT_M);
}

/** Whether a place is in a scene, or no more than `metres` outside of its bounds along any axis. */
export function isWithin(
  { bounds }: Pick<Scene, "bounds">,
  place: Vector3,
  metres: number,
): boolean {
  const [min, max] = [bounds?.min, bounds?.max];
  if (!min || !max) {
    return true;
  }
  const low = [min.x, min.y, min.z];
  const high = [max.x, max.y, max.z];
  return place.every(
    (value, axis) => value > (low[axis] ?? 0) - metres && value < (high[axis] ?? 0) + metres,
  );
}

/** On narrow screens more is shown from bottom to top, so that something is seen from side to side. */
export function firstFovDeg(width: number, height: number): number {
  return width < height ? 80 : DEFAULT_FOV_DEG;
}

/**
 * Where a visit begins that no link began: at the photograph nearest to the scene's middle, looking
 * where it looks. Without photographs in the open nearest to the middle, along the street.
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
  return { eye, headingDeg: farthestView(x, y, buildings), pitchDeg: 0, fovDeg };
}

/**
 * The place nearest to the middle, on growing rings, that is well away from any building; where it
 * is narrow, nearer to them.
 */
export function open(middle: Vector3, buildings: Walls): readonly [number, number] {
  for (const clearance of [8, 4, 2]) {
    const around = ring(0, 0, clearance, 12);
    const clear = ([x, y]: readonly [number, number]) =>
      !buildings.contain(x, y) && around.every(([dx, dy]) => !buildings.contain(x + dx, y + dy));
    for (let radius = 0; radius <= FARTHEST_M; radius += 4) {
      const found = ring(middle[0], middle[1], radius, radius * 1.5).find(clear);
      if (found) {
        return found;
      }
    }
  }
  return [middle[0], middle[1]];
}

/** The direction in which one sees farthest between the buildings, the first of equals. */
export function farthestView(x: number, y: number, buildings: Walls): number {
  let best = { headingDeg: 0, metres: -1 };
  for (let headingDeg = 0; headingDeg < 360; headingDeg += 10) {
    const [dx, dy] = [Math.sin(radians(headingDeg)), Math.cos(radians(headingDeg))];
    let metres = 0;
    while (metres < FARTHEST_M && !buildings.contain(x + dx * metres, y + dy * metres)) {
      metres += 2;
    }
    // Where nothing is built there is nothing to see.
    if (metres < FARTHEST_M && metres > best.metres) {
      best = { headingDeg, metres };
    }
  }
  return best.headingDeg;
}

/** Places on a circle: at least one. */
function ring(x: number, y: number, radius: number, count: number): [number, number][] {
  const places = Math.max(1, Math.round(count));
  return Array.from({ length: places }, (_, index) => {
    const angle = (2 * Math.PI * index) / places;
    return [x + radius * Math.sin(angle), y + radius * Math.cos(angle)];
  });
}
