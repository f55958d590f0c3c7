import { Gateway } from "./support/gateway";
import type { Server } from "./support/server";
import { expect, test } from "./support/test";

test("goes on with another replica when its own ends in the middle of a walk", async ({
  walker,
  keep,
}) => {
  const gateway = await Gateway.start();
  try {
    await walker.open(gateway.url);
    await walker.hold("w", 300);
    await walker.sees("final");
    const before = await walker.pose();
    const busy = async () => {
      const calls = await Promise.all(gateway.replicas.map(callsOf));
      return calls.flatMap((count, index) => (count > 0 ? [index] : []));
    };
    // Calls of a moment may be under way elsewhere.
    await expect
      .poll(async () => (await busy()).length, { message: "one of them has the session" })
      .toBe(1);
    const [index] = await busy();
    const [own, other] = [gateway.replicas[index ?? 0], gateway.replicas[1 - (index ?? 0)]];
    await walker.page.keyboard.down("w");
    await walker.page.waitForTimeout(200);
    await own?.kill();
    await walker.page.waitForTimeout(300);
    await walker.page.keyboard.up("w");
    await walker.sees("final");
    const after = await walker.pose();
    const [x, y] = [0, 1].map((axis) => (after.eye[axis] ?? 0) - (before.eye[axis] ?? 0));
    expect(Math.hypot(x ?? 0, y ?? 0), "metres further on").toBeGreaterThan(0.3);
    expect((await walker.colours()).spread).toBeGreaterThan(20);
    await expect
      .poll(() => (other ? callsOf(other) : 0), { message: "the other one has the session now" })
      .toBeGreaterThan(0);
    await keep("another replica");
  } finally {
    await gateway.stop();
  }
});

/** Calls in flight. */
async function callsOf(server: Server): Promise<number> {
  const text = await (await fetch(`${server.url}/metrics`)).text();
  const [, count] = /^flaneur_requests_in_flight (\d+)/m.exec(text) ?? [];
  return Number(count);
}
