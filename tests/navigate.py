"""Someone who walks about for a while, over Navigate, and looks closely at every frame that comes.

Called by python_clients.rs as: navigate.py HOST:PORT SCENE SECONDS. Ends with a traceback at the first
frame that is not as the contract has it.
"""

import math
import queue
import random
import sys
import threading
import time

import grpc
from google.protobuf import message_factory

from foreign_client import PACKAGE, Client

# How long anything may take, seconds.
PATIENCE = 60
# Who stands is sent nothing: so long is listened for it, seconds.
SILENCE = 0.5
# Steps a second while walking.
STEPS = 15
# Looks about as wide as high, and small: what is measured here is order, not speed.
SIZE = (160, 96)


class Navigation:
    """One call of Navigate: views go in, frames come out and are checked as they do."""

    def __init__(self, client, scene):
        service = client.pool.FindServiceByName(f"{PACKAGE}.RenderService")
        method = service.FindMethodByName("Navigate")
        self.update_class = message_factory.GetMessageClass(method.input_type)
        frame_class = message_factory.GetMessageClass(method.output_type)
        self.scene, self.sent, self.last = scene, {}, None
        self.arrivals, self.latencies = 0, []
        self.finals = set()
        self.updates, self.arrived = queue.Queue(), queue.Queue()
        call = client.channel.stream_stream(
            f"/{PACKAGE}.RenderService/Navigate",
            request_serializer=lambda message: message.SerializeToString(),
            response_deserializer=frame_class.FromString,
        )
        frames = call(iter(self.updates.get, None))
        threading.Thread(target=self.listen, args=(frames,), daemon=True).start()

    def listen(self, frames):
        try:
            for frame in frames:
                self.arrived.put(frame)
            self.arrived.put(None)
        except grpc.RpcError as error:
            self.arrived.put(error)

    def look(self, **view):
        """Says where one looks from now on; the view's number, which grows by more than one."""
        sequence = max(self.sent, default=0) + random.randint(1, 3)
        update = self.update_class(scene=self.scene if not self.sent else "", sequence=sequence)
        for name, value in {"width": SIZE[0], "height": SIZE[1], "fov_deg": 60, **view}.items():
            if name == "eye":
                update.view.eye.x, update.view.eye.y, update.view.eye.z = value
            else:
                setattr(update.view, name, value)
        update.received_frame = self.last.number if self.last else 0
        self.sent[sequence] = update.view
        self.updates.put(update)
        return sequence

    def take(self, timeout):
        """The next frame, checked and acknowledged; None where none comes in time."""
        try:
            frame = self.arrived.get(timeout=timeout)
        except queue.Empty:
            return None
        assert frame is not None, "the stream ended though nobody asked for it"
        if isinstance(frame, grpc.RpcError):
            raise frame
        self.check(frame)
        self.last = frame
        self.arrivals += 1
        self.latencies.append(frame.latency_ms)
        self.updates.put(self.update_class(received_frame=frame.number))
        return frame

    def check(self, frame):
        last = self.last
        # Order: frames are numbered without a gap, and never go back to an older view.
        assert frame.number == (last.number + 1 if last else 1), (frame.number, last)
        assert not last or frame.sequence >= last.sequence, (frame.sequence, last.sequence)
        # Echo: the very view that has this number.
        assert frame.sequence in self.sent, frame.sequence
        assert frame.view == self.sent[frame.sequence], (frame.view, self.sent[frame.sequence])
        assert frame.media_type == "image/jpeg" and not frame.fault, frame
        assert jpeg_size(frame.image) == (frame.view.width, frame.view.height)
        # Finality: nothing follows, and nothing is missing.
        assert frame.sequence not in self.finals, f"{frame.sequence} was final"
        if frame.final:
            assert frame.complete and frame.remaining == 0, frame
            self.finals.add(frame.sequence)
        # Figures that can be.
        assert not last or frame.bytes_received >= last.bytes_received
        assert 0 < frame.render_ms and 0 < frame.encode_ms
        assert frame.latency_ms >= frame.render_ms, (frame.latency_ms, frame.render_ms)

    def rest(self, sequence):
        """Stands until the picture is final, and then in silence."""
        until = time.monotonic() + PATIENCE
        while not (self.last and self.last.sequence == sequence and self.last.final):
            assert time.monotonic() < until, f"view {sequence} never becomes final"
            self.take(timeout=1)
        after = self.take(timeout=SILENCE)
        assert after is None, f"frame {after.number} after the final one {self.last.number}"

    def end(self):
        """Says no more; the stream then ends well."""
        self.updates.put(None)
        assert self.arrived.get(timeout=PATIENCE) is None


def jpeg_size(data):
    """Width and height as the file's frame header has them."""
    assert data[:2] == b"\xff\xd8" and data[-2:] == b"\xff\xd9", "a whole JPEG"
    at = 2
    while data[at + 1] not in (0xC0, 0xC1, 0xC2):
        at += 2 + int.from_bytes(data[at + 2 : at + 4], "big")
    height, width = (int.from_bytes(data[at + i : at + i + 2], "big") for i in (5, 7))
    return width, height


def way(client, scene):
    """Where the survey's vehicle went."""
    panoramas = client.call("PanoramaService", "StreamPanoramas", scene=scene)
    panoramas.sort(key=lambda panorama: panorama.time)
    return [(p.position.x, p.position.y, p.position.z) for p in panoramas]


def main(address, scene, seconds):
    random.seed(5)
    client = Client(address)
    places = way(client, scene)
    walk = Navigation(client, scene)
    ends = time.monotonic() + float(seconds)
    modes = rounds = 0
    walk.rest(walk.look(eye=places[0], heading_deg=35, pitch_deg=0))
    while rounds == 0 or time.monotonic() < ends:
        start, goal = random.sample(places, 2)
        heading = math.degrees(math.atan2(goal[0] - start[0], goal[1] - start[1])) % 360
        # From one place to another, half turning round, without waiting for any frame.
        for step in range(2 * STEPS):
            share = step / (2 * STEPS)
            eye = [a + share * (b - a) for a, b in zip(start, goal)]
            latest = walk.look(eye=eye, heading_deg=(heading + 90 * share) % 360, pitch_deg=3)
            beat = time.monotonic() + 1 / STEPS
            while (left := beat - time.monotonic()) > 0:
                walk.take(timeout=left)
        walk.rest(latest)
        # Another mode, and back; another size.
        modes = modes % 8 + 1
        walk.rest(walk.look(eye=goal, heading_deg=heading, pitch_deg=0, mode=modes))
        walk.rest(walk.look(eye=goal, heading_deg=heading, pitch_deg=0, width=96, height=64))
        rounds += 1
    walk.end()
    latencies = sorted(walk.latencies)
    median = latencies[len(latencies) // 2]
    print(
        f"{rounds} rounds: {len(walk.sent)} views, {walk.arrivals} frames, {len(walk.finals)} final, "
        f"median {median:.0f} ms"
    )
    # There is something to see before all is there.
    assert walk.arrivals > len(walk.finals), "frames come on the way"


if __name__ == "__main__":
    main(*sys.argv[1:])
