import { Link } from "./support/link";
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
    await expect(walker.page.locator(".quality")).toHaveText("No connection");
    await expect(walker.spoken).toHaveText("No connection");
    // The last picture stays, and turns with the head.
    await walker.drag([600, 400], [560, 400]);
    expect((await walker.colours()).spread).toBeGreaterThan(20);
    await keep("lost");
    const again = await Server.start(server.port);
    try {
      await walker.tryNow();
      await walker.sees("final");
      const after = await walker.pose();
      expect(after.eye).toEqual(pose.eye);
      await expect(walker.spoken).toHaveText(/^Connected again/);
      await walker.hold("w", 300);
      await walker.sees("final");
    } finally {
      await again.kill();
    }
  } finally {
    await server.kill();
  }
});

test("shows nothing worse than before once the server is back", async ({ walker }) => {
  const server = await Server.start();
  try {
    await walker.open(server.url);
    await server.kill();
    await walker.sees("lost");
    await walker.stage.evaluate((stage) => {
      const seen = { frames: 0, final: 0, pictures: 0 };
      Object.assign(window, { seen });
      stage.addEventListener("flaneur:frame", (event) => {
        seen.frames += 1;
        seen.final += (event as CustomEvent<{ final: boolean }>).detail.final ? 1 : 0;
      });
      new MutationObserver((changes) => {
        const added = changes.flatMap(({ addedNodes }) => [...addedNodes]);
        seen.pictures += added.filter((node) => node instanceof HTMLCanvasElement).length;
      }).observe(stage, { childList: true });
    });
    const again = await Server.start(server.port);
    try {
      await walker.tryNow();
      await walker.sees("final");
      const seen = await walker.page.evaluate(
        () => (window as unknown as { seen: Record<string, number> }).seen,
      );
      expect(seen.frames, "coarse ones came first").toBeGreaterThan(seen.final ?? 0);
      expect(seen.pictures).toBe(seen.final);
    } finally {
      await again.kill();
    }
  } finally {
    await server.kill();
  }
});

test("takes no second place where the server has not noticed that the connection was lost", async ({
  walker,
}) => {
  const server = await Server.start(0, undefined, ["--max-sessions", "1"]);
  const link = await Link.to(server.port);
  try {
    await walker.open(link.url);
    link.cut();
    await walker.sees("lost");
    link.mend();
    await walker.sees("final");
    await walker.hold("w", 300);
    await walker.sees("final");
  } finally {
    await link.close();
    await server.kill();
  }
});

test("says that the server is stopping in words that are for people", async ({ walker }) => {
  const server = await Server.start();
  try {
    await walker.open(server.url);
    // It is said for a moment only: soon nobody answers.
    await walker.status.evaluate((status) => {
      const said: string[] = [];
      Object.assign(window, { said });
      new MutationObserver(() => {
        said.push(`${status.dataset.quality}: ${status.textContent}`);
      }).observe(status, { attributes: true, childList: true, subtree: true });
    });
    server.stop();
    const said = () =>
      walker.page.evaluate(() => (window as unknown as { said: string[] }).said.join("\n"));
    await expect.poll(said).toMatch(/^trouble: .*the server is stopping/m);
    expect(await said()).not.toContain("watch");
  } finally {
    await server.kill();
  }
});
