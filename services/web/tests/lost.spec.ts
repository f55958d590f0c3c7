import { Server } from "./support/server";
import { expect, test } from "./support/test";

test("says that the server is gone, and goes on where one was once it is back", async ({
  walker,
  keep,
}) => {
  const server = await Server.start();
  try {
    await walker.open(server.url);
    await walker.hold("w", 300);
    await walker.sees("final");
    const pose = await walker.pose();
    await server.kill();
    await walker.sees("lost");
    await expect(walker.page.getByText("No connection")).toBeVisible();
    // The last picture stays, and turns with the head.
    await walker.drag([600, 400], [560, 400]);
    expect((await walker.colours()).spread).toBeGreaterThan(20);
    await keep("lost");
    const again = await Server.start(server.port);
    try {
      await walker.page.getByRole("button", { name: "Try now" }).click();
      await walker.sees("final");
      const after = await walker.pose();
      expect(after.eye).toEqual(pose.eye);
      await walker.hold("w", 300);
      await walker.sees("final");
    } finally {
      await again.kill();
    }
  } finally {
    await server.kill();
  }
});
