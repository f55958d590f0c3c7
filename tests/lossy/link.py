"""A network link that delays and loses packets, for a machine whose kernel cannot.

    link.py NAME DELAY_MS LOSS_PERCENT SEED

Makes the interface NAME with the address 10.99.0.1 in the present network namespace. A packet
that is sent to 10.99.0.2 comes back, after the delay and unless it is lost, as one that 10.99.0.2 has
sent: a server on 10.99.0.1 is reached at 10.99.0.2, over this link both ways. Both checksums, of IP
and of TCP, stay valid when two addresses change places. Prints "ready", ends when its input does, and
then prints how many packets were carried and lost.
"""

import fcntl
import heapq
import os
import random
import select
import struct
import subprocess
import sys
import time

TUNSETIFF = 0x400454CA
IFF_TUN, IFF_NO_PI = 0x0001, 0x1000


def main():
    name, delay_s, loss, seed = (
        sys.argv[1],
        float(sys.argv[2]) / 1000,
        float(sys.argv[3]) / 100,
        int(sys.argv[4]),
    )
    interface = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
    fcntl.ioctl(interface, TUNSETIFF, struct.pack("16sH22x", name.encode(), IFF_TUN | IFF_NO_PI))
    for command in (
        ["ip", "link", "set", name, "mtu", "1500", "up"],
        ["ip", "address", "add", "10.99.0.1/24", "dev", name],
    ):
        subprocess.run(command, check=True)
    print("ready", flush=True)

    chance = random.Random(seed)
    under_way = []  # (when, number, packet), the earliest first
    carried = lost = 0
    while True:
        now = time.monotonic()
        while under_way and under_way[0][0] <= now:
            os.write(interface, heapq.heappop(under_way)[2])
        wait = under_way[0][0] - now if under_way else None
        readable, _, _ = select.select([interface, sys.stdin], [], [], wait)
        if sys.stdin in readable:
            print(f"carried {carried} lost {lost}", flush=True)
            return
        if interface not in readable:
            continue
        packet = os.read(interface, 65536)
        if packet[0] >> 4 != 4:
            continue  # the kernel's own announcements over IPv6
        if chance.random() < loss:
            lost += 1
            continue
        carried += 1
        packet = packet[:12] + packet[16:20] + packet[12:16] + packet[20:]
        heapq.heappush(under_way, (time.monotonic() + delay_s, carried, packet))


main()
