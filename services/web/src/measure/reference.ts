import type { Scene } from "../gen/flaneur/v1/scene_pb";
import { TEXT } from "../strings";

/** What a scene's coordinates are, and refer to: the CRS by its name and its code. */
export function referenceOf({ crs, crsName, geographicOrigin }: Scene): string {
  if (crs.toLowerCase() !== "local") {
    const name = crsName ? `${crsName} (${crs})` : crs;
    // A compound CRS is called by both of its parts.
    const heights = crsName.includes(" + ") ? "" : `; ${TEXT.heightsUnnamed}`;
    return `${name}: ${TEXT.axes}${heights}`;
  }
  if (!geographicOrigin) {
    return `${TEXT.localFrame}: ${TEXT.axes}`;
  }
  const { latitudeDeg, longitudeDeg } = geographicOrigin;
  const frame = TEXT.localFrameAt(latitudeDeg.toFixed(8), longitudeDeg.toFixed(8));
  return `${frame}: ${TEXT.axes}`;
}
