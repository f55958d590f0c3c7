import { radians } from "../geometry/angles";

/** What has an inside. */
export interface Walls {
  contain(x: number, y: number): boolean;
}

/** One comes no nearer to a wall than about that, metres. */
const CLEARANCE_M = 1;
/** So far one is turned aside to go along a wall, degrees; who walks into it straight on stands still. */
const ASIDE_DEG = [0, 15, -15, 30, -30, 45, -45, 60, -60];

/**
 * A step in plan that enters no building: where it would, what is left of it beside the wall. Who is
 * inside already, as beneath an arch, goes freely. The window has the same rule, and both are tested
 * with slide.cases.json.
 */
export function slid(
  [x, y]: readonly [number, number],
  [dx, dy]: readonly [number, number],
  walls: Walls,
): readonly [number, number] {
  const length = Math.hypot(dx, dy);
  if (length === 0 || walls.contain(x, y)) {
    return [dx, dy];
  }
  for (const aside of ASIDE_DEG) {
    const [sin, cos] = [Math.sin(radians(aside)), Math.cos(radians(aside))];
    const [u, v] = [(dx * cos + dy * sin) / length, (dy * cos - dx * sin) / length];
    const reach = length * cos + CLEARANCE_M;
    // A long step must not lead through a thin house.
    let free = true;
    for (let at = reach; free && at > 0; at -= CLEARANCE_M) {
      free = !walls.contain(x + u * at, y + v * at);
    }
    if (free) {
      return [u * length * cos, v * length * cos];
    }
  }
  return [0, 0];
}
