import type { Clients } from "../api/clients";
import { type Camera, ImageLayer } from "../gen/flaneur/v1/panorama_pb";

/** Larger photographs are fetched at half or a quarter of their size, pixels. */
const WIDEST = 2400;

/** No photograph has so many bytes. */
const MOST_BYTES = 256 << 20;

/** The finest level of a camera's photograph that is not too wide. */
export function levelFor(camera: Camera): number {
  const finest = Math.max(0, Math.ceil(Math.log2(Math.max(camera.width, 1) / WIDEST)));
  return Math.min(finest, Math.max(camera.levels.length - 1, 0));
}

/** A stored photograph, put together from its parts. */
export async function fetchPhotograph(
  client: Clients["panoramas"],
  key: {
    readonly scene: string;
    readonly panorama: string;
    readonly camera: string;
    readonly level: number;
  },
  signal: AbortSignal,
): Promise<Blob> {
  const { scene, panorama, camera, level } = key;
  const images = [{ panorama, camera, level, layer: ImageLayer.COLOUR }];
  const parts: Uint8Array<ArrayBuffer>[] = [];
  let type = "";
  let bytes = 0;
  let total = 0;
  for await (const part of client.streamImages({ scene, images }, { signal })) {
    if (part.totalBytes > BigInt(MOST_BYTES) || Number(part.offset) !== bytes) {
      throw new Error(`part at ${part.offset} of ${part.totalBytes} bytes follows ${bytes}`);
    }
    type = part.mediaType;
    total = Number(part.totalBytes);
    bytes += part.data.length;
    parts.push(part.data as Uint8Array<ArrayBuffer>);
  }
  if (bytes === 0 || bytes !== total) {
    throw new Error(`the file has ${total} bytes, ${bytes} came`);
  }
  return new Blob(parts, { type });
}
