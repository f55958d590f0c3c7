import path from "node:path";
import { connect } from "../src/api/clients";
import { distance } from "../src/geometry/vector";
import { placeOf } from "../src/photographs/catalogue";
import { PICTURES } from "./support/place";
import { expect, test } from "./support/test";
import { Walker } from "./support/walker";

test("a link reproduces the view", async ({ server, walker, context }) => {
  await walker.open(server.url);
  await walker.drag([600, 400], [420, 360]);
  await walker.hold("w", 300);
  await walker.sees("final");
  const pose = await walker.pose();
  await walker.page.getByRole("button", { name: "Copy a link" }).click();
  const link = await walker.page.evaluate(() => navigator.clipboard.readText());
  const other = new Walker(await context.newPage());
  await other.open(link);
  expect(await other.pose()).toEqual(pose);
  const [one, two] = [await walker.colours(), await other.colours()];
  expect(Math.abs(one.mean - two.mean)).toBeLessThan(1);
  expect(Math.abs(one.spread - two.spread)).toBeLessThan(1);
});

test("fills the window when it changes its size", async ({ server, walker, keep }) => {
  await walker.open(server.url);
  await walker.asks(() => walker.page.setViewportSize({ width: 700, height: 900 }));
  await walker.sees("final");
  expect(await walker.coverage()).toBe(true);
  await walker.asks(() => walker.page.setViewportSize({ width: 1400, height: 500 }));
  await walker.sees("final");
  expect(await walker.coverage()).toBe(true);
  await keep("resized");
});

test("two pages walk at once, each for itself", async ({ server, walker, context }) => {
  const other = new Walker(await context.newPage());
  await Promise.all([walker.open(server.url), other.open(server.url)]);
  const start = await walker.pose();
  expect(await other.pose()).toEqual(start);
  await walker.page.bringToFront();
  await walker.hold("w", 300);
  await other.page.bringToFront();
  await other.drag([400, 400], [700, 400]);
  await Promise.all([walker.sees("final"), other.sees("final")]);
  const [one, two] = [await walker.pose(), await other.pose()];
  expect(distance(one.eye, start.eye)).toBeGreaterThan(0.3);
  expect(two.eye).toEqual(start.eye);
  expect(two.headingDeg).not.toBeCloseTo(start.headingDeg, 0);
});

test("the map leads through the street, and follows", async ({ server, walker, keep }) => {
  await walker.open(server.url);
  const map = walker.page.locator(".inset-map");
  await expect(map.locator("canvas")).toBeVisible();
  await expect(map.locator(".here")).toBeVisible();
  const start = await walker.pose();
  const box = await map.boundingBox();
  if (!box) {
    throw new Error("the map has no box");
  }
  // Thirty pixels above the middle: ahead along the street's north.
  await walker.page.mouse.click(box.x + box.width / 2 + 12, box.y + box.height / 2 - 30);
  await walker.sees("final");
  const there = await walker.pose();
  expect(distance(there.eye, start.eye)).toBeGreaterThan(4);
  expect(distance(there.eye, start.eye)).toBeLessThan(60);
  expect(there.eye[1]).toBeGreaterThan(start.eye[1]);
  expect(there.headingDeg).toBe(start.headingDeg);
  await keep("map");
});

test("works on a narrow screen, and with fingers", async ({ server, browser }) => {
  const context = await browser.newContext({
    viewport: { width: 360, height: 740 },
    hasTouch: true,
    isMobile: true,
    colorScheme: "dark",
  });
  const walker = new Walker(await context.newPage());
  await walker.open(server.url);
  const width = await walker.page.evaluate(() => document.documentElement.scrollWidth);
  expect(width).toBeLessThanOrEqual(360);
  await walker.page.screenshot({ path: path.join(PICTURES, "narrow.png") });
  for (const name of ["Measure", "Map", "Copy a link", "How to move"]) {
    const box = await walker.page.getByRole("button", { name }).first().boundingBox();
    expect((box?.x ?? 999) + (box?.width ?? 999), name).toBeLessThanOrEqual(360);
  }
  const start = await walker.pose();
  // A tap on the road ahead goes there.
  await walker.page.touchscreen.tap(180, 520);
  await expect.poll(async () => distance((await walker.pose()).eye, start.eye)).toBeGreaterThan(1);
  await walker.sees("final");
  // Two fingers, from 60 to 120 pixels apart, show half as much.
  const before = await walker.pose();
  const fingers = await context.newCDPSession(walker.page);
  const touch = (type: "touchStart" | "touchMove" | "touchEnd", half?: number) => {
    const touchPoints =
      half === undefined
        ? []
        : [
            { x: 180 - half, y: 400, id: 0 },
            { x: 180 + half, y: 400, id: 1 },
          ];
    return fingers.send("Input.dispatchTouchEvent", { type, touchPoints });
  };
  await touch("touchStart", 30);
  for (let half = 33; half <= 60; half += 3) {
    await touch("touchMove", half);
  }
  await touch("touchEnd");
  const after = await walker.pose();
  expect(after.fovDeg / before.fovDeg).toBeGreaterThan(0.45);
  expect(after.fovDeg / before.fovDeg).toBeLessThan(0.6);
  expect(after.eye).toEqual(before.eye);
  await context.close();
});

test("can be used by keys alone", async ({ server, walker }) => {
  await walker.open(server.url);
  const { page } = walker;
  const start = await walker.pose();
  await walker.hold("PageDown", 400);
  await page.keyboard.press("Enter");
  await expect.poll(async () => distance((await walker.pose()).eye, start.eye)).toBeGreaterThan(1);
  await page.keyboard.press("g");
  const nearest = async () => {
    const { eye } = await walker.pose();
    let metres = Number.POSITIVE_INFINITY;
    for await (const panorama of connect(server.url).panoramas.streamPanoramas({
      scene: "sample",
    })) {
      metres = Math.min(metres, distance(placeOf(panorama), eye));
    }
    return metres;
  };
  await expect.poll(nearest).toBeLessThan(0.01);
  await page.keyboard.press("m");
  await expect(page.getByRole("region", { name: "Measure" })).toBeVisible();
  await page.keyboard.press("Escape");
  await expect(page.getByRole("region", { name: "Measure" })).toBeHidden();
  await page.keyboard.press("?");
  await expect(page.getByRole("dialog", { name: "How to move" })).toBeVisible();
  await page.keyboard.press("Escape");
  // Tab reaches every tool, and each has a name.
  const names = new Set<string>();
  for (let count = 0; count < 14; count += 1) {
    await page.keyboard.press("Tab");
    const name = await page.evaluate(() => {
      const { activeElement: active } = document;
      const label = active?.closest("label")?.textContent;
      return active?.getAttribute("aria-label") ?? label ?? active?.textContent ?? "";
    });
    names.add(name.trim());
  }
  for (const name of ["Street", "Measure", "Map", "Copy a link to this view", "How to move"]) {
    expect([...names]).toContain(name);
  }
});

test("without WebGL the street works, and the map is a plain one", async ({
  server,
  walker,
  keep,
}) => {
  await walker.page.addInitScript(() => {
    const original = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (
      this: HTMLCanvasElement,
      kind: string,
      ...rest: unknown[]
    ) {
      return /webgl/.test(kind) ? null : Reflect.apply(original, this, [kind, ...rest]);
    } as typeof original;
  });
  await walker.open(server.url);
  await expect(walker.page.getByRole("img", { name: "Map. Click" })).toBeVisible();
  expect((await walker.colours()).spread).toBeGreaterThan(20);
  await keep("without_webgl");
});

test("without JavaScript the page says what is needed", async ({ server, browser }) => {
  const context = await browser.newContext({ javaScriptEnabled: false });
  const page = await context.newPage();
  await page.goto(server.url);
  // Parsed as an element only where scripts are off.
  const words = page.locator("noscript p");
  await expect(words).toBeInViewport({ ratio: 1 });
  await expect(words).toContainText("needs JavaScript");
  await page.screenshot({ path: path.join(PICTURES, "without_javascript.png") });
  await context.close();
});
