import { type Client, createClient } from "@connectrpc/connect";
import { createGrpcWebTransport } from "@connectrpc/connect-web";
import { FootprintService } from "../gen/flaneur/v1/footprint_pb";
import { GroundService } from "../gen/flaneur/v1/ground_pb";
import { PanoramaService } from "../gen/flaneur/v1/panorama_pb";
import { RenderService } from "../gen/flaneur/v1/render_pb";
import { SceneService } from "../gen/flaneur/v1/scene_pb";

/** The services of one server. */
export interface Clients {
  readonly scenes: Client<typeof SceneService>;
  readonly footprints: Client<typeof FootprintService>;
  readonly ground: Client<typeof GroundService>;
  readonly panoramas: Client<typeof PanoramaService>;
  readonly render: Client<typeof RenderService>;
}

/** Over gRPC-Web, from the server at `baseUrl`. */
export function connect(baseUrl: string): Clients {
  const transport = createGrpcWebTransport({ baseUrl });
  return {
    scenes: createClient(SceneService, transport),
    footprints: createClient(FootprintService, transport),
    ground: createClient(GroundService, transport),
    panoramas: createClient(PanoramaService, transport),
    render: createClient(RenderService, transport),
  };
}
