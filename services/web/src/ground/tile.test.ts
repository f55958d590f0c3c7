import { create } from "@bufbuild/protobuf";
import { describe, expect, it } from "vitest";
import { GroundTileSchema } from "../gen/flaneur/v1/ground_pb";
import { decodeTile, heightAt } from "./tile";

const SIZE = { origin: { x: 1000, y: 2000 }, spacingM: 0.5, columns: 3, rows: 2 };

describe("a tile of the terrain", () => {
  it("is decoded from steps, and interpolated between its nodes", () => {
    // 10, 11, 12 in the south, 20, 21, 22 in the north.
    const message = create(GroundTileSchema, {
      ...SIZE,
      heightStepsMm: [10_000, 1000, 1000, 8000, 1000, 1000],
    });
    const tile = decodeTile(message);
    expect(tile && [...tile.heights]).toEqual([10, 11, 12, 20, 21, 22]);
    const at = (x: number, y: number) => tile && heightAt(tile, x, y);
    expect(at(1000, 2000)).toBe(10);
    expect(at(1001, 2000.5)).toBe(22);
    expect(at(1000.25, 2000.25)).toBeCloseTo(15.5);
    expect(at(1000.75, 2000.125)).toBeCloseTo(14);
    expect(at(999.9, 2000)).toBeUndefined();
    expect(at(1001.1, 2000)).toBeUndefined();
  });

  it("has holes, beside which the nearest known node counts", () => {
    // The middle of the south is unknown, and so is all of the north but its east.
    const message = create(GroundTileSchema, {
      ...SIZE,
      heightStepsMm: [10_000, 2000, 10_000],
      known: new Uint8Array([0b100101]),
    });
    const tile = decodeTile(message);
    expect(tile && heightAt(tile, 1000.1, 2000.1)).toBe(10);
    expect(tile && heightAt(tile, 1000.9, 2000.4)).toBe(22);
  });

  it("that makes no sense is none", () => {
    const refused = (fields: object) =>
      decodeTile(
        create(GroundTileSchema, { ...SIZE, heightStepsMm: [1, 2, 3, 4, 5, 6], ...fields }),
      );
    expect(refused({})).toBeDefined();
    expect(refused({ heightStepsMm: [1, 2, 3] })).toBeUndefined();
    expect(refused({ heightStepsMm: [1, 2, 3, 4, 5, 6, 7] })).toBeUndefined();
    expect(refused({ known: new Uint8Array([255, 255]) })).toBeUndefined();
    expect(refused({ spacingM: 0 })).toBeUndefined();
    expect(refused({ columns: 4_000_000_000, rows: 4_000_000_000 })).toBeUndefined();
  });
});
