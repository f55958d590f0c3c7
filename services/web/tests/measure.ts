/**
 * How long a person waits, at 1024 x 512, as JSON: from pressing a key to the first picture of the
 * new view on the screen, and from moving the hand to the turned picture on the screen. The first
 * press of each visitor is told apart: that of the first one, and those of who comes later.
 *
 *   npm run measure              FLANEUR=... chooses the binary, TRIES=... how often, VISITORS=...
 *                                how many come, SERVED=... a store instead of the sample street, and
 *                                SCENE=... which of its scenes
 */
import os from "node:os";
import { chromium, type Page } from "@playwright/test";
import config from "../playwright.config";
import { summary } from "./support/figures";
import { Server } from "./support/server";
import { makeStreet } from "./support/street";
import { Walker } from "./support/walker";

const TRIES = Number(process.env.TRIES ?? 25);
const VISITORS = Number(process.env.VISITORS ?? 5);
const { SERVED, SCENE } = process.env;

if (!SERVED) {
  makeStreet();
}
const server = await Server.start(0, SERVED);
const browser = await chromium.launch(config.use?.launchOptions);
try {
  const first: number[] = [];
  for (let visitor = 0; visitor < VISITORS; visitor += 1) {
    const came = await comes();
    first.push((await presses(came, "w")).shownMs);
    await came.page.close();
  }
  const walker = await comes();
  const { page } = walker;
  first.push((await presses(walker, "w")).shownMs);
  const keys: number[] = [];
  const servers: number[] = [];
  for (let trial = 0; trial < TRIES; trial += 1) {
    const { shownMs, serverMs } = await presses(walker, trial % 2 === 0 ? "s" : "w");
    keys.push(shownMs);
    servers.push(serverMs);
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
    first_press_of_first_visitor_ms: Math.round(first[0] ?? Number.NaN),
    first_press_of_later_visitors_ms: summary(first.slice(1)),
    key_to_frame_ms: summary(keys),
    of_which_server_ms: summary(servers),
    turn_to_screen_ms: summary(turns),
  };
  process.stdout.write(`${JSON.stringify(report, undefined, 2)}\n`);
} finally {
  await browser.close();
  await server.kill();
}

/** Somebody opens the page, and waits for the whole picture. */
async function comes(): Promise<Walker> {
  const page = await browser.newPage({ viewport: { width: 1024, height: 512 } });
  const walker = new Walker(page);
  await walker.open(server.url + (SCENE ? `/?scene=${encodeURIComponent(SCENE)}` : ""));
  await page.evaluate(listen);
  return walker;
}

/** What a press of a key takes; waits for the whole picture. */
async function presses(walker: Walker, key: string): Promise<KeyWait> {
  await walker.hold(key, 60);
  await walker.page.waitForTimeout(300);
  await walker.sees("final");
  return (await taken(walker.page)).key ?? { shownMs: Number.NaN, serverMs: Number.NaN };
}

interface KeyWait {
  readonly shownMs: number;
  /** Of which the server took. */
  readonly serverMs: number;
}

interface Waits {
  /** From the press of a key until the first picture of the new view is on the screen. */
  key?: KeyWait;
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
