import { create } from "@bufbuild/protobuf";
import { type View, ViewSchema } from "../gen/flaneur/v1/render_pb";
import { LAYERS, type Layer } from "../state/layer";
import type { Pinhole } from "./pinhole";

/** A view as the server takes it. */
export function viewMessage(camera: Pinhole, layer: Layer): View {
  const [x, y, z] = camera.pose.eye;
  const { headingDeg, pitchDeg, fovDeg } = camera.pose;
  return create(ViewSchema, {
    eye: { x, y, z },
    headingDeg,
    pitchDeg,
    extent: { case: "fovDeg", value: fovDeg },
    width: camera.width,
    height: camera.height,
    mode: LAYERS[layer],
    mayShrink: true,
  });
}
