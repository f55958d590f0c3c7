import type { Scene } from "../gen/flaneur/v1/scene_pb";
import { TEXT } from "../strings";

/** What a scene's coordinates refer to: the CRS by its name and its code. */
export function referenceOf({ crs, crsName, geographicOrigin }: Scene): string {
  if (crs.toLowerCase() !== "local") {
    return crsName ? `${crsName} (${crs})` : crs;
  }
  if (!geographicOrigin) {
    return TEXT.localFrame;
  }
  const { latitudeDeg, longitudeDeg } = geographicOrigin;
  return TEXT.localFrameAt(latitudeDeg.toFixed(8), longitudeDeg.toFixed(8));
}
