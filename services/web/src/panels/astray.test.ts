import { create } from "@bufbuild/protobuf";
import { describe, expect, it } from "vitest";
import { FrameSchema } from "../gen/flaneur/v1/render_pb";
import { SceneSchema } from "../gen/flaneur/v1/scene_pb";
import { isAstray } from "./astray";
import cases from "./astray.cases.json";

const vector = ([x = 0, y = 0, z = 0]: number[]) => ({ x, y, z });

describe("who sees nothing of the scene", () => {
  const { min, max } = cases.bounds;
  const scene = create(SceneSchema, { bounds: { min: vector(min), max: vector(max) } });

  it.each(cases.frames)(
    "is told from who sees $what",
    ({ eye, unsurveyed, blank, astray, ...view }) => {
      const frame = create(FrameSchema, {
        view: {
          eye: vector(eye),
          pitchDeg: view.pitch ?? 0,
          extent: { case: "fovDeg", value: 60 },
        },
        unsurveyedShare: unsurveyed,
        blankShare: blank,
      });
      expect(isAstray(frame, scene)).toBe(astray);
    },
  );
});
