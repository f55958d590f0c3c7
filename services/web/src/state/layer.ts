import { Mode } from "../gen/flaneur/v1/render_pb";

/** What the picture shows; the names stand in links. */
export const LAYERS = {
  hybrid: Mode.HYBRID,
  mesh: Mode.MESH,
  points: Mode.POINTS,
  sources: Mode.SOURCES,
  uncertainty: Mode.UNCERTAINTY,
  colours: Mode.POINTS_COLOUR,
  wireframe: Mode.WIREFRAME,
  depth: Mode.DEPTH,
  normals: Mode.NORMALS,
} as const;

export type Layer = keyof typeof LAYERS;

export const LAYER_NAMES = Object.keys(LAYERS) as Layer[];

/** The first ones are offered at once, the others on demand. */
export const MAIN_LAYERS: readonly Layer[] = ["hybrid", "mesh", "points", "sources", "uncertainty"];
export const MORE_LAYERS: readonly Layer[] = ["colours", "wireframe", "depth", "normals"];

export function isLayer(name: string): name is Layer {
  return Object.hasOwn(LAYERS, name);
}
