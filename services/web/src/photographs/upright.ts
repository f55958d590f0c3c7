import type { Camera, Panorama } from "../gen/flaneur/v1/panorama_pb";

/**
 * By how many quarter turns clockwise a photograph is to be shown so that what is up in the world
 * is up in the picture: 0 to 3. Cameras of a rig may hang on their side, or upside down.
 */
export function quarterTurns(panorama: Panorama, camera: Camera): number {
  const rig = panorama.worldFromRig?.rows ?? [];
  const cam = camera.camFromRig?.rows ?? [];
  // Up of the world is the last row of world_from_rig, seen from the rig.
  const up = [rig[6] ?? 0, rig[7] ?? 0, rig[8] ?? 1];
  const along = (row: number) =>
    up.reduce((sum, value, axis) => sum + value * (cam[row * 3 + axis] ?? 0), 0);
  // In the picture x is right and y is down.
  const [right, down] = [along(0), along(1)];
  if (Math.hypot(right, down) < 1e-6) {
    return 0;
  }
  // Clockwise from the top of the picture to where up is; undone by turning it back.
  const angle = Math.atan2(right, -down);
  return (4 - Math.round(angle / (Math.PI / 2))) % 4;
}
