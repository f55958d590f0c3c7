import { create } from "@bufbuild/protobuf";
import { describe, expect, it } from "vitest";
import { PanoramaSchema } from "../gen/flaneur/v1/panorama_pb";
import { placeOf } from "./catalogue";

describe("where a photograph was taken", () => {
  // The rig looks to the west: its right is north, its front is west.
  const panorama = create(PanoramaSchema, {
    position: { x: 651_000, y: 6_861_000, z: 41 },
    worldFromRig: { rows: [0, -1, 0, 1, 0, 0, 0, 0, 1] },
    cameras: [
      { id: "front", positionInRig: { x: 0, y: 0.5, z: 0.865 } },
      { id: "right", positionInRig: { x: 0.25, y: 0, z: 1 } },
    ],
  });

  it("is the centre of its camera, not the origin of its rig", () => {
    const [front, right] = panorama.cameras;
    expect(placeOf(panorama, front)).toEqual([650_999.5, 6_861_000, 41.865]);
    expect(placeOf(panorama, right)).toEqual([651_000, 6_861_000.25, 42]);
  });

  it("is that of the first camera where none is named, and the rig's where there is none", () => {
    expect(placeOf(panorama)).toEqual([650_999.5, 6_861_000, 41.865]);
    expect(placeOf(create(PanoramaSchema, { position: { x: 1, y: 2, z: 3 } }))).toEqual([1, 2, 3]);
  });
});
