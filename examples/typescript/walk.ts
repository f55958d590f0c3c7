// Streams footprints and points of a street, has a picture rendered, and walks a few steps.
//
//   npm ci && npm start -- http://127.0.0.1:7878 [SCENE]
//
// The pictures of the walk are written to walk_1.jpg, walk_2.jpg, …
import { writeFile } from "node:fs/promises";
import { createClient } from "@connectrpc/connect";
import { createGrpcTransport } from "@connectrpc/connect-node";
import { FootprintService } from "./gen/flaneur/v1/footprint_pb.js";
import { PanoramaService } from "./gen/flaneur/v1/panorama_pb.js";
import { PointService } from "./gen/flaneur/v1/point_pb.js";
import { RenderService } from "./gen/flaneur/v1/render_pb.js";
import { SceneService } from "./gen/flaneur/v1/scene_pb.js";

const [address = "http://127.0.0.1:7878", wanted] = process.argv.slice(2);
const transport = createGrpcTransport({ baseUrl: address });

const { scenes } = await createClient(SceneService, transport).listScenes({});
const walkable = scenes.filter(({ panoramaCount }) => panoramaCount > 0n);
const found = wanted ? walkable.find(({ name }) => name === wanted) : walkable[0];
if (!found) {
  console.error(`${address} has no scene ${wanted ?? ""} with photographs to walk along`);
  process.exit(1);
}
const scene = found.name;
console.log(`${scene}: ${found.crs}, ${found.imageCount} photographs`);

// Where the drive went: the places of its panoramas, in the order in which they were taken.
const places = [];
for await (const panorama of createClient(PanoramaService, transport).streamPanoramas({ scene })) {
  const { x = 0, y = 0, z = 0 } = panorama.position ?? {};
  places.push({ eye: { x, y, z }, time: panorama.time });
}
places.sort((a, b) => a.time.localeCompare(b.time));
const { x = 0, y = 0, z = 0 } = places[0]?.eye ?? found.origin ?? {};

// Buildings within 50 m of there, with their attributes.
const footprints = createClient(FootprintService, transport);
let buildings = 0;
for await (const batch of footprints.streamFootprints({ scene, centre: { x, y }, radiusM: 50 })) {
  for (const { id, heightM, uncertaintyM } of batch.footprints) {
    if (buildings++ < 3) console.log(`  ${id}: ${heightM.toFixed(1)} m high, ± ${uncertaintyM} m`);
  }
}
console.log(`${buildings} buildings within 50 m`);

// Points: the octree's nodes, then the LAZ bytes of the coarsest, as they stand in the COPC file.
const points = createClient(PointService, transport);
for (const { name: source, pointCount, recordLength } of found.pointSources) {
  const nodes = [];
  for await (const page of points.getHierarchy({ scene, source })) nodes.push(...page.entries);
  const root = nodes.find(({ key, pointCount }) => key?.level === 0 && pointCount > 0);
  let bytes = 0;
  if (root?.key) {
    for await (const part of points.streamChunks({ scene, source, nodes: [root.key] })) {
      bytes += part.data.length;
    }
  }
  console.log(`${source}: ${pointCount} points of ${recordLength} bytes in ${nodes.length} nodes`);
  console.log(`  the coarsest has ${root?.pointCount ?? 0} of them in ${bytes} bytes`);
}

// One picture, once everything for it is there.
const view = {
  eye: { x, y, z },
  headingDeg: 35,
  pitchDeg: 2,
  extent: { case: "fovDeg" as const, value: 65 },
  width: 640,
  height: 360,
};
const render = createClient(RenderService, transport);
const picture = await render.renderFrame({ scene, view });
console.log(`picture: ${picture.image.length} bytes of ${picture.mediaType}`);

// A walk: each view is asked for once the picture of the one before is final.
const steps = places.slice(0, 3);
let next: () => void = () => {};
async function* views() {
  for (const [index, { eye }] of steps.entries()) {
    const arrived = new Promise<void>((resolve) => (next = resolve));
    yield { scene, sequence: BigInt(index + 1), view: { ...view, eye } };
    await arrived;
  }
}
let frames = 0;
for await (const frame of render.navigate(views())) {
  frames += 1;
  if (frame.final && frame.sequence <= steps.length) {
    await writeFile(`walk_${frame.sequence}.jpg`, frame.image);
    console.log(`step ${frame.sequence}: final after ${frames} frames, ${frame.latencyMs.toFixed(0)} ms`);
    frames = 0;
    next();
  }
}
