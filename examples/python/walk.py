"""Streams footprints and points of a street, has a picture rendered, and walks a few steps.

    pip install -r requirements.txt
    python walk.py 127.0.0.1:7878 [SCENE]

The points go to points.npy (x, y, z), the pictures to picture.png and walk_1.jpg, walk_2.jpg, ...
"""

import pathlib
import queue
import sys

import grpc
import lazrs
import numpy as np

# The messages, straight from the .proto files.
sys.path.append(str(pathlib.Path(__file__).parents[2] / "proto/proto"))
v1 = {}
for name in ["scene", "footprint", "panorama", "point", "render"]:
    messages, services = grpc.protos_and_services(f"flaneur/v1/{name}.proto")
    v1[name] = messages
    v1[f"{name}s"] = services


def footprints(channel, scene, centre, radius_m):
    """The buildings around a place, as the survey has them."""
    stub = v1["footprints"].FootprintServiceStub(channel)
    request = v1["footprint"].StreamFootprintsRequest(scene=scene, radius_m=radius_m)
    request.centre.x, request.centre.y = centre.x, centre.y
    return [found for batch in stub.StreamFootprints(request) for found in batch.footprints]


def coarse_points(channel, scene, source):
    """World positions of the octree's first node: an overview of the whole source."""
    stub = v1["points"].PointServiceStub(channel)
    point = v1["point"]
    pages = stub.GetHierarchy(point.GetHierarchyRequest(scene=scene, source=source.name))
    nodes = [entry for page in pages for entry in page.entries if entry.point_count]
    root = min(nodes, key=lambda node: node.key.level)
    request = point.StreamChunksRequest(scene=scene, source=source.name, nodes=[root.key])
    laz = b"".join(part.data for part in stub.StreamChunks(request))
    raw = np.zeros(root.point_count * source.record_length, np.uint8)
    chunks = [(root.point_count, len(laz))]
    lazrs.decompress_points_with_chunk_table(laz, source.laszip_vlr, raw, chunks)
    # Unaltered integers; what lies behind X, Y and Z in a record does not matter here.
    integers = raw.reshape(root.point_count, -1)[:, :12].copy().view("<i4")
    scale, offset = source.scale, source.offset
    return integers * [scale.x, scale.y, scale.z] + [offset.x, offset.y, offset.z]


def view(panorama, heading_deg):
    """What someone sees who stands where a panorama was taken."""
    eye = panorama.position
    render = v1["render"]
    looks = {"heading_deg": heading_deg, "pitch_deg": 2, "fov_deg": 65}
    return render.View(eye=eye, width=640, height=360, **looks)


def walk(channel, scene, views):
    """The final frame of each view, one after the other, and how many came before it."""
    stub = v1["renders"].RenderServiceStub(channel)
    updates = queue.Queue()
    frames = stub.Navigate(iter(updates.get, None))
    for sequence, wanted in enumerate(views, start=1):
        update = v1["render"].ViewUpdate(scene=scene, sequence=sequence, view=wanted)
        updates.put(update)
        for earlier, frame in enumerate(frames):
            if frame.sequence == sequence and frame.final:
                yield frame, earlier
                break
    updates.put(None)


def main(address, wanted=None):
    channel = grpc.insecure_channel(address)
    scenes = v1["scenes"].SceneServiceStub(channel)
    listed = scenes.ListScenes(v1["scene"].ListScenesRequest()).scenes
    walkable = [scene for scene in listed if scene.panorama_count and wanted in (None, scene.name)]
    if not walkable:
        sys.exit(f"{address} has no scene {wanted or ''} with photographs to walk along")
    scene = walkable[0]
    print(f"{scene.name}: {scene.crs}, {scene.image_count} photographs")

    # Where the drive went: its panoramas, in the order in which they were taken.
    request = v1["panorama"].StreamPanoramasRequest(scene=scene.name)
    panoramas = v1["panoramas"].PanoramaServiceStub(channel).StreamPanoramas(request)
    places = sorted(panoramas, key=lambda panorama: panorama.time)

    for footprint in footprints(channel, scene.name, places[0].position, 50)[:3]:
        print(f"  {footprint.id}: {footprint.height_m:.1f} m high, ± {footprint.uncertainty_m} m")

    clouds = [coarse_points(channel, scene.name, source) for source in scene.point_sources]
    np.save("points.npy", np.concatenate(clouds))
    print(f"points.npy: {sum(map(len, clouds))} points of {len(clouds)} sources")

    render = v1["render"]
    quality = render.Quality(encoding=render.ENCODING_PNG)
    request = {"scene": scene.name, "view": view(places[0], 35), "quality": quality}
    frame = v1["renders"].RenderServiceStub(channel).RenderFrame(render.RenderFrameRequest(**request))
    pathlib.Path("picture.png").write_bytes(frame.image)
    print(f"picture.png: {len(frame.image)} bytes")

    views = [view(place, 35) for place in places[:3]]
    for step, (frame, earlier) in enumerate(walk(channel, scene.name, views), start=1):
        pathlib.Path(f"walk_{step}.jpg").write_bytes(frame.image)
        print(f"walk_{step}.jpg: {frame.latency_ms:.0f} ms, {earlier} frames before it")


if __name__ == "__main__":
    main(*sys.argv[1:])
