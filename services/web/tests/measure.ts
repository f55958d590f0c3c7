/**
 * How long a person waits, at 1024 x 512, as JSON: from pressing a key to the first picture of the
 * new view on the screen, and from moving the hand to the turned picture on the screen.
 *
 *   npm run measure              FLANEUR=... chooses the binary, TRIES=... how often
 */
import os from "node:os";
import { chromium, type Page } from "@playwright/test";
import config from "../playwright.config";
import { summary } from "./support/figures";
import { Server } from "./support/server";
import { makeStreet } from "./support/street";
import { Walker } from "./support/walker";

const TRIES = Number(process.env.TRIES ?? 25);

makeStreet();
const server = await Server.start();
const browser = await chromium.launch(config.use?.launchOptions);
try {
  const page = await browser.newPage({ viewport: { width: 1024, height: 512 } });
  const walker = new Walker(page);
  await walker.open(server.url);
  const keys: number[] = [];
  const servers: number[] = [];
  for (let trial = 0; trial < TRIES; trial += 1) {
    const wait = firstFrameAfterKey(page);
    await walker.hold(trial % 2 === 0 ? "w" : "s", 60);
    const { shownMs, serverMs } = await wait;
    keys.push(shownMs);
    servers.push(serverMs);
    await page.waitForTimeout(150);
    await walker.sees("final");
  }
  const turns: number[] = [];
  for (let trial = 0; trial < TRIES; trial += 1) {
    const wait = shownAfterDrag(page);
    await walker.drag([520, 200], [trial % 2 === 0 ? 440 : 600, 210]);
    turns.push(...(await wait));
    await walker.sees("final");
  }
  const report = {
    viewport: "1024x512",
    cores: os.cpus().length,
    load: Math.round((os.loadavg()[0] ?? 0) * 10) / 10,
    key_to_frame_ms: summary(keys),
    of_which_server_ms: summary(servers),
    turn_to_screen_ms: summary(turns),
  };
  process.stdout.write(`${JSON.stringify(report, undefined, 2)}\n`);
} finally {
  await browser.close();
  await server.kill();
}

/** From the press of the next key until a picture from another place is on the screen. */
function firstFrameAfterKey(page: Page): Promise<{ shownMs: number; serverMs: number }> {
  return page.evaluate(
    () =>
      new Promise((resolve) => {
        const stage = document.querySelector(".stage");
        window.addEventListener(
          "keydown",
          ({ timeStamp }) => {
            const shown = (event: Event) => {
              const { sequence, latencyMs } = (event as CustomEvent).detail;
              // What was under way when the key went down shows the former view.
              if (sequence <= last) {
                return;
              }
              stage?.removeEventListener("flaneur:frame", shown);
              requestAnimationFrame(() =>
                resolve({ shownMs: performance.now() - timeStamp, serverMs: latencyMs }),
              );
            };
            const last: bigint = BigInt(stage?.getAttribute("data-sequence") ?? 0);
            stage?.addEventListener("flaneur:frame", shown);
          },
          { once: true },
        );
      }),
  );
}

/** From each move of the hand until the picture that it turned is on the screen. */
function shownAfterDrag(page: Page): Promise<number[]> {
  return page.evaluate(
    () =>
      new Promise((resolve) => {
        const stage = document.querySelector(".stage");
        const waits: number[] = [];
        let movedAt: number | undefined;
        const moved = (event: Event) => {
          movedAt ??= event.timeStamp;
        };
        const shown = () => {
          const since = movedAt;
          movedAt = undefined;
          if (since !== undefined) {
            // By the next frame of the screen this one is on it.
            requestAnimationFrame(() => waits.push(performance.now() - since));
          }
        };
        stage?.addEventListener("pointermove", moved);
        stage?.addEventListener("flaneur:shown", shown);
        stage?.addEventListener(
          "pointerup",
          () => {
            stage.removeEventListener("pointermove", moved);
            stage.removeEventListener("flaneur:shown", shown);
            setTimeout(() => resolve(waits), 100);
          },
          { once: true },
        );
      }),
  );
}
