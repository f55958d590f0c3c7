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
  await page.evaluate(listen);
  const keys: number[] = [];
  const servers: number[] = [];
  for (let trial = 0; trial < TRIES; trial += 1) {
    await walker.hold(trial % 2 === 0 ? "w" : "s", 60);
    await page.waitForTimeout(300);
    await walker.sees("final");
    const { shownMs, serverMs } = (await taken(page)).key ?? {};
    keys.push(shownMs ?? Number.NaN);
    servers.push(serverMs ?? Number.NaN);
  }
  const turns: number[] = [];
  for (let trial = 0; trial < TRIES; trial += 1) {
    await walker.drag([520, 200], [trial % 2 === 0 ? 440 : 600, 210]);
    await page.waitForTimeout(300);
    await walker.sees("final");
    turns.push(...(await taken(page)).turns);
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

interface Waits {
  /** From the press of a key until the first picture of the new view is on the screen. */
  key?: { readonly shownMs: number; readonly serverMs: number };
  /** From each move of the hand until the picture that it turned is on the screen. */
  turns: number[];
}

/** What was waited for since it was last asked. */
function taken(page: Page): Promise<Waits> {
  return page.evaluate(() => {
    const page = window as unknown as { waits: Waits };
    const waits = page.waits;
    page.waits = { turns: [] };
    return waits;
  });
}

/** Runs in the page, and takes the times there. What is shown is on the screen by its next frame. */
function listen(): void {
  const page = window as unknown as { waits: Waits };
  page.waits = { turns: [] };
  const stage = document.querySelector<HTMLElement>(".stage");
  let key: { atMs: number; last: bigint } | undefined;
  let movedMs: number | undefined;
  window.addEventListener(
    "keydown",
    ({ timeStamp }) => {
      // Pictures of this view, or of former ones, may still be under way.
      key = { atMs: timeStamp, last: BigInt(stage?.dataset.sequence ?? 0) };
    },
    { capture: true },
  );
  stage?.addEventListener("flaneur:frame", (event) => {
    const { sequence, latencyMs } = (event as CustomEvent).detail;
    const pressed = key;
    if (pressed && sequence > pressed.last) {
      key = undefined;
      requestAnimationFrame(() => {
        page.waits.key = { shownMs: performance.now() - pressed.atMs, serverMs: latencyMs };
      });
    }
  });
  stage?.addEventListener("pointermove", ({ timeStamp, buttons }) => {
    movedMs ??= buttons > 0 ? timeStamp : undefined;
  });
  stage?.addEventListener("flaneur:shown", () => {
    const since = movedMs;
    movedMs = undefined;
    if (since !== undefined) {
      requestAnimationFrame(() => page.waits.turns.push(performance.now() - since));
    }
  });
}
