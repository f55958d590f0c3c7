import { create } from "@bufbuild/protobuf";
import { describe, expect, it } from "vitest";
import { FrameSchema } from "../gen/flaneur/v1/render_pb";
import { SceneSchema } from "../gen/flaneur/v1/scene_pb";
import { isAstray } from "./astray";

describe("who sees nothing of the scene", () => {
  const scene = create(SceneSchema, {
    bounds: { min: { x: 0, y: 0, z: 30 }, max: { x: 400, y: 300, z: 60 } },
  });
  const sees = (unsurveyedShare: number, blankShare: number, z = 32) =>
    isAstray(
      create(FrameSchema, { view: { eye: { x: 200, y: 100, z } }, unsurveyedShare, blankShare }),
      scene,
    );

  it("is one whose picture is blank, wherever they are", () => {
    expect(sees(1, 1)).toBe(true);
    expect(sees(0.9995, 0.9995, 4000)).toBe(true);
    expect(sees(0.99, 0.99, 4000)).toBe(false);
  });

  it("is not one who looks at the sky over a street, but one who is in the sky", () => {
    expect(sees(1, 0)).toBe(false);
    expect(sees(1, 0, 4000)).toBe(true);
  });

  it("is nobody where the server does not say", () => {
    expect(sees(0, 0, 4000)).toBe(false);
  });
});
