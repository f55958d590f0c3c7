"""A client that knows nothing of Flaneur but an address: it learns the services by reflection.

Called by foreign_client.rs as: foreign_client.py HOST:PORT FOLDER_WITH_THE_SURVEY'S_LAZ_FILES.
Ends with a traceback at the first thing that is not as it should be.
"""

import pathlib
import sys
import zlib

import grpc
import laspy
import lazrs
import numpy as np
from google.protobuf import descriptor_pool, message_factory
from grpc_reflection.v1alpha.proto_reflection_descriptor_database import (
    ProtoReflectionDescriptorDatabase,
)

PACKAGE = "flaneur.v1"
# What identifies a point in the survey and in the chunks; raw integers, but for the time.
FIELDS = ["X", "Y", "Z", "intensity", "classification", "return_number", "gps_time"]


class Client:
    """Calls any method of any service by its name, with plain dictionaries."""

    def __init__(self, address):
        self.channel = grpc.insecure_channel(address)
        grpc.channel_ready_future(self.channel).result(timeout=20)
        self.database = ProtoReflectionDescriptorDatabase(self.channel)
        self.pool = descriptor_pool.DescriptorPool(self.database)

    def call(self, service, method, **fields):
        """The answers as a list: one for a unary method."""
        descriptor = self.pool.FindServiceByName(f"{PACKAGE}.{service}").FindMethodByName(method)
        request = message_factory.GetMessageClass(descriptor.input_type)(**fields)
        answer = message_factory.GetMessageClass(descriptor.output_type)
        path = f"/{PACKAGE}.{service}/{method}"
        kind = self.channel.unary_stream if descriptor.server_streaming else self.channel.unary_unary
        callable_ = kind(
            path,
            request_serializer=lambda message: message.SerializeToString(),
            response_deserializer=answer.FromString,
        )
        answers = callable_(request, timeout=60)
        return list(answers) if descriptor.server_streaming else [answers]

    def refusal(self, service, method, **fields):
        """Code and message of a call that must fail."""
        try:
            self.call(service, method, **fields)
        except grpc.RpcError as error:
            return error.code(), error.details()
        raise AssertionError(f"{service}/{method} took {fields}")


def main(address, survey):
    client = Client(address)
    services = set(client.database.get_services())
    for name in ["Scene", "Footprint", "Ground", "Panorama", "Point"]:
        assert f"{PACKAGE}.{name}Service" in services, services
    assert "grpc.health.v1.Health" in services, services

    (listed,) = client.call("SceneService", "ListScenes")
    (scene,) = listed.scenes
    (described,) = client.call("SceneService", "GetScene", scene=scene.name)
    assert described.scene == scene

    footprints(client, scene)
    rigs = panoramas(client, scene)
    images(client, scene, rigs[0])
    points = sum(decode_all(client, scene, source, survey) for source in scene.point_sources)
    refusals(client, scene, rigs[0])
    print(f"{scene.name}: {scene.footprint_count} footprints, {len(rigs)} panoramas, {points} points")


def footprints(client, scene):
    batches = client.call("FootprintService", "StreamFootprints", scene=scene.name)
    every = {f.id: box(f) for batch in batches for f in batch.footprints}
    assert len(every) == scene.footprint_count
    west, south, east, north = next(iter(every.values()))
    bbox = {"min_x": west, "min_y": south, "max_x": east, "max_y": north}
    batches = client.call("FootprintService", "StreamFootprints", scene=scene.name, bbox=bbox)
    near = {f.id for batch in batches for f in batch.footprints}
    meets = {
        key
        for key, b in every.items()
        if b[0] <= east and b[2] >= west and b[1] <= north and b[3] >= south
    }
    assert near == meets and 0 < len(near) < len(every), (near, meets)


def box(footprint):
    coordinates = np.concatenate(
        [ring.coordinates for polygon in footprint.polygons for ring in polygon.rings]
    ).reshape(-1, 2)
    return (*coordinates.min(axis=0), *coordinates.max(axis=0))


def panoramas(client, scene):
    every = client.call("PanoramaService", "StreamPanoramas", scene=scene.name)
    assert len(every) == scene.panorama_count
    middle = every[len(every) // 2].position
    centre = {"x": middle.x, "y": middle.y}
    distance = lambda p: np.hypot(p.position.x - middle.x, p.position.y - middle.y)
    radius = sorted(map(distance, every))[len(every) // 2] + 1e-6
    near = client.call(
        "PanoramaService", "StreamPanoramas", scene=scene.name, centre=centre, radius_m=radius
    )
    assert 0 < len(near) < len(every)
    assert {p.id for p in near} == {p.id for p in every if distance(p) <= radius}
    distances = [distance(p) for p in near]
    assert distances == sorted(distances), "nearest first"
    for panorama in near:
        rotation = np.array(panorama.world_from_rig.rows).reshape(3, 3)
        assert np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-9)
    return near


def images(client, scene, panorama):
    camera = panorama.cameras[0]
    keys = [
        {"panorama": panorama.id, "camera": camera.id, "level": level}
        for level in reversed(range(len(camera.levels)))
    ]
    parts = client.call("PanoramaService", "StreamImages", scene=scene.name, images=keys)
    sizes = []
    for key in keys:
        ours = [p for p in parts if p.image.level == key["level"]]
        data = b"".join(p.data for p in ours)
        assert [p.offset for p in ours] == list(np.cumsum([0] + [len(p.data) for p in ours[:-1]]))
        assert len(data) == ours[0].total_bytes
        announced = camera.levels[key["level"]]
        assert (len(data), zlib.crc32(data)) == (announced.byte_size, announced.crc32)
        assert ours[0].media_type == "image/jpeg"
        assert data[:3] == b"\xff\xd8\xff" and data[-2:] == b"\xff\xd9", "a whole JPEG"
        sizes.append(len(data))
    assert sizes == sorted(sizes), "finer levels are larger"


def decode_all(client, scene, source, survey):
    """Decodes every chunk of a source: together they are the survey's file, point for point."""
    pages = client.call("PointService", "GetHierarchy", scene=scene.name, source=source.name)
    nodes = [entry for page in pages for entry in page.entries if entry.point_count]
    assert sum(node.point_count for node in nodes) == source.point_count
    layout = laspy.PointFormat(source.point_format)
    if source.extra_bytes_vlr:
        extra = laspy.vlrs.known.ExtraBytesVlr()
        extra.parse_record_data(source.extra_bytes_vlr)
        for dimension in extra.type_of_extra_dims():
            layout.add_extra_dimension(dimension)
    assert layout.size == source.record_length

    records = []
    for start in range(0, len(nodes), 4096):
        keys = [node.key for node in nodes[start : start + 4096]]
        parts = client.call(
            "PointService", "StreamChunks", scene=scene.name, source=source.name, nodes=keys
        )
        at = 0
        for node in nodes[start : start + 4096]:
            data = b""
            while len(data) < node.byte_size:
                assert parts[at].key == node.key and parts[at].offset == len(data)
                data += parts[at].data
                at += 1
            assert zlib.crc32(data) == node.crc32
            raw = np.zeros(node.point_count * source.record_length, np.uint8)
            lazrs.decompress_points_with_chunk_table(
                data, source.laszip_vlr, raw, [(node.point_count, len(data))]
            )
            records.append(laspy.PackedPointRecord.from_buffer(raw.tobytes(), layout))
        assert at == len(parts)

    ours = sorted_columns(records)
    files = sorted(pathlib.Path(survey).rglob("*.la[sz]"))
    originals = [laspy.read(file) for file in files]
    for original in originals:
        assert tuple(original.header.scales) == triple(source.scale)
        assert tuple(original.header.offsets) == triple(source.offset)
    theirs = sorted_columns([original.points for original in originals])
    for field, mine, other in zip(FIELDS, ours, theirs, strict=True):
        assert np.array_equal(mine, other), field
    return len(ours[0])


def sorted_columns(records):
    columns = [np.concatenate([np.asarray(r[field]) for r in records]) for field in FIELDS]
    order = np.lexsort(columns)
    return [column[order] for column in columns]


def triple(point):
    return (point.x, point.y, point.z)


def refusals(client, scene, panorama):
    not_found, invalid = grpc.StatusCode.NOT_FOUND, grpc.StatusCode.INVALID_ARGUMENT
    image = {"panorama": panorama.id, "camera": panorama.cameras[0].id, "level": 99}
    source = scene.point_sources[0].name
    nan = {"min_x": float("nan"), "min_y": 0, "max_x": 1, "max_y": 1}
    turned = {"min_x": 0, "min_y": 5, "max_x": 1, "max_y": 1}
    deep = {"level": 30, "x": 0, "y": 0, "z": 0}
    cases = [
        (not_found, "nowhere", "SceneService", "GetScene", {"scene": "nowhere"}),
        (not_found, "level 99", "PanoramaService", "StreamImages", {"images": [image]}),
        (not_found, "30-0-0-0", "PointService", "StreamChunks", {"source": source, "nodes": [deep]}),
        (not_found, "sea", "PointService", "GetHierarchy", {"source": "sea"}),
        (invalid, "bbox.min_x", "FootprintService", "StreamFootprints", {"bbox": nan}),
        (invalid, "bbox.min_y", "GroundService", "StreamGround", {"bbox": turned}),
        (invalid, "radius_m", "PanoramaService", "StreamPanoramas", {"centre": {}, "radius_m": -1}),
    ]
    for code, name, service, method, fields in cases:
        got = client.refusal(service, method, **{"scene": scene.name, **fields})
        assert got[0] == code and name in got[1], (got, code, name)


if __name__ == "__main__":
    main(*sys.argv[1:])
