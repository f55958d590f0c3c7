import { Server } from "./support/server";
import { expect, test } from "./support/test";
import { Walker } from "./support/walker";

test("says that the server is full, and comes in once somebody has gone", async ({
  walker,
  context,
  keep,
}) => {
  const server = await Server.start(0, undefined, ["--max-sessions", "1"]);
  try {
    const first = await context.newPage();
    await new Walker(first).open(server.url);
    await walker.page.goto(server.url);
    await walker.sees("full");
    await expect(walker.status).toContainText("Server full");
    await expect(walker.status).toContainText("as many sessions as it takes");
    await expect(walker.status).not.toContainText("No connection");
    await keep("full");
    await first.close();
    await walker.sees("final");
  } finally {
    await server.kill();
  }
});

test("shows what a server makes that makes small pictures only", async ({ walker, keep }) => {
  const server = await Server.start(0, undefined, ["--max-pixels", "100000"]);
  try {
    await walker.open(server.url);
    expect(await walker.coverage()).toBe(true);
    const size = () =>
      walker.stage.evaluate((stage) => {
        const newest = [...stage.querySelectorAll<HTMLCanvasElement>("canvas.picture")].pop();
        return (newest?.width ?? 0) * (newest?.height ?? 0);
      });
    expect(await size()).toBeLessThanOrEqual(100_000);
    expect(await size()).toBeGreaterThan(98_000);
    // A click goes where it points, whatever the size of the picture.
    const before = await walker.pose();
    await walker.click([512, 600]);
    await expect.poll(async () => (await walker.pose()).eye).not.toEqual(before.eye);
    await walker.sees("final");
    await keep("small_pictures");
  } finally {
    await server.kill();
  }
});

test("says of a click that the server is gone", async ({ walker, keep }) => {
  const server = await Server.start();
  try {
    await walker.open(server.url);
    await server.kill();
    await walker.sees("lost");
    await walker.click([512, 500]);
    await expect(walker.page.getByText("there is no connection to the server")).toBeVisible();
    await keep("click_without_server");
  } finally {
    await server.kill();
  }
});
