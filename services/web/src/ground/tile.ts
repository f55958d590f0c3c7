import type { GroundTile } from "../gen/flaneur/v1/ground_pb";

/** A tile of the terrain, its heights decoded. */
export interface Heights {
  /** South-west node. */
  readonly x: number;
  readonly y: number;
  readonly spacing: number;
  readonly columns: number;
  readonly rows: number;
  /** Metres, row by row from the south; NaN where unknown. */
  readonly heights: Float64Array;
}

/** Far more than a tile ever has. */
const MOST_NODES = 1 << 20;

/** Decodes a tile; undefined where the message makes no sense. */
export function decodeTile(tile: GroundTile): Heights | undefined {
  const nodes = tile.columns * tile.rows;
  const { origin, known, heightStepsMm: steps } = tile;
  if (!origin || !(tile.spacingM > 0) || nodes < 1 || nodes > MOST_NODES) {
    return undefined;
  }
  if (known.length !== 0 && known.length !== Math.ceil(nodes / 8)) {
    return undefined;
  }
  const heights = new Float64Array(nodes).fill(Number.NaN);
  let millimetres = 0;
  let next = 0;
  for (let node = 0; node < nodes; node += 1) {
    if (known.length !== 0 && (((known[node >> 3] ?? 0) >> (node & 7)) & 1) === 0) {
      continue;
    }
    millimetres += steps[next] ?? Number.NaN;
    next += 1;
    heights[node] = millimetres / 1000;
  }
  if (next !== steps.length) {
    return undefined;
  }
  const { columns, rows, spacingM: spacing } = tile;
  return { x: origin.x, y: origin.y, spacing, columns, rows, heights };
}

/**
 * Height at a place, metres: between the four nodes around it where all are known, else that of the
 * nearest that is. Undefined outside of the tile, and where none of the four is known.
 */
export function heightAt(tile: Heights, x: number, y: number): number | undefined {
  const [u, v] = [(x - tile.x) / tile.spacing, (y - tile.y) / tile.spacing];
  if (!(u >= 0 && v >= 0 && u <= tile.columns - 1 && v <= tile.rows - 1)) {
    return undefined;
  }
  const column = Math.min(Math.floor(u), Math.max(tile.columns - 2, 0));
  const row = Math.min(Math.floor(v), Math.max(tile.rows - 2, 0));
  const [s, t] = [u - column, v - row];
  const node = (i: number, j: number) =>
    tile.heights[
      Math.min(row + j, tile.rows - 1) * tile.columns + Math.min(column + i, tile.columns - 1)
    ] ?? Number.NaN;
  const corners = [
    { height: node(0, 0), weight: (1 - s) * (1 - t) },
    { height: node(1, 0), weight: s * (1 - t) },
    { height: node(0, 1), weight: (1 - s) * t },
    { height: node(1, 1), weight: s * t },
  ];
  const between = corners.reduce((sum, corner) => sum + corner.height * corner.weight, 0);
  if (!Number.isNaN(between)) {
    return between;
  }
  const known = corners.filter((corner) => !Number.isNaN(corner.height));
  known.sort((a, b) => b.weight - a.weight);
  return known[0]?.height;
}
