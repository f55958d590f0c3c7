import { create } from "@bufbuild/protobuf";
import { describe, expect, it } from "vitest";
import { SceneSchema } from "../gen/flaneur/v1/scene_pb";
import { earthOf } from "./earth";

const ORIGIN = { x: 651_517, y: 6_861_087, z: 53 };

describe("the map's frame", () => {
  it("is the scene's own, and goes back to a millimetre", () => {
    const scene = create(SceneSchema, {
      origin: ORIGIN,
      geographic: {
        origin: { latitudeDeg: 48.85, longitudeDeg: 2.34, heightM: 90 },
        longitudePerM: { x: 1.366e-5, y: 1.1e-7 },
        latitudePerM: { x: -7.2e-8, y: 8.99e-6 },
      },
    });
    const earth = earthOf(scene);
    expect(earth.toLngLat(ORIGIN.x, ORIGIN.y)).toEqual([2.34, 48.85]);
    const [lng, lat] = earth.toLngLat(ORIGIN.x + 100, ORIGIN.y + 10);
    expect(lng).toBeCloseTo(2.34 + 1.366e-3 + 1.1e-6, 12);
    expect(lat).toBeCloseTo(48.85 - 7.2e-6 + 8.99e-5, 12);
    const [x, y] = earth.toScene([lng, lat]);
    expect(x).toBeCloseTo(ORIGIN.x + 100, 3);
    expect(y).toBeCloseTo(ORIGIN.y + 10, 3);
  });

  it("is metres about the equator where the scene is nowhere on Earth", () => {
    const earth = earthOf(create(SceneSchema, { origin: { x: 28, y: -13, z: -6 } }));
    const [lng, lat] = earth.toLngLat(28 + 111.32, -13 - 222.64);
    expect([lng, lat]).toEqual([expect.closeTo(0.001, 9), expect.closeTo(-0.002, 9)]);
    expect(earth.toScene([lng, lat])[1]).toBeCloseTo(-13 - 222.64, 6);
  });
});
