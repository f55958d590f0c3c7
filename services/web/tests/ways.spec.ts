import path from "node:path";
import type { Locator } from "@playwright/test";
import { connect } from "../src/api/clients";
import { distance } from "../src/geometry/vector";
import { Buildings } from "../src/map/buildings";
import { Catalogue, placeOf } from "../src/photographs/catalogue";
import { PICTURES } from "./support/place";
import { linkTo } from "./support/places";
import { expect, test } from "./support/test";
import { Walker } from "./support/walker";

test("a link reproduces the view", async ({ server, walker, context }) => {
  await walker.open(server.url);
  await walker.drag([600, 400], [420, 360]);
  await walker.hold("w", 300);
  const pose = await walker.pose();
  await walker.sees("final");
  await walker.page.getByRole("button", { name: "Copy a link" }).click();
  await expect(walker.page.getByText("Link copied")).toBeVisible();
  const link = await walker.page.evaluate(() => navigator.clipboard.readText());
  const other = new Walker(await context.newPage());
  await other.open(link);
  expect(await other.pose()).toEqual(pose);
  expect(await other.differs(await walker.picture())).toBeLessThan(0.5);
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
  await expect.poll(async () => distance((await walker.pose()).eye, start.eye)).toBeGreaterThan(4);
  await walker.sees("final");
  const there = await walker.pose();
  expect(distance(there.eye, start.eye)).toBeLessThan(60);
  expect(there.eye[1]).toBeGreaterThan(start.eye[1]);
  expect(there.headingDeg).toBe(start.headingDeg);
  await keep("map");
  // Who has moved the map walks on as before, and it comes along.
  const [x, y] = [box.x + 80, box.y + 150];
  await walker.drag([x, y], [x + 60, y - 40]);
  await walker.hold("w", 500);
  await expect
    .poll(async () => distance((await walker.pose()).eye, there.eye))
    .toBeGreaterThan(0.5);
  const aside = async () => {
    const here = await map.locator(".here").boundingBox();
    const middle = (here?.x ?? Number.NaN) + (here?.width ?? 0) / 2 - box.x - box.width / 2;
    return Math.abs(middle);
  };
  await expect.poll(aside).toBeLessThan(3);
  await walker.sees("final");
});

test("nobody gets into a building, neither by the map nor on foot", async ({
  server,
  walker,
  keep,
}) => {
  await walker.open(server.url);
  const clients = connect(server.url);
  const buildings = new Buildings(clients.footprints, "sample");
  const start = await walker.pose();
  await buildings.fetch(start.eye, 300);
  const catalogue = new Catalogue(clients.panoramas, "sample");
  await catalogue.fetch();
  const map = walker.page.locator(".inset-map");
  await expect(map.locator("canvas")).toBeVisible();
  const box = await map.boundingBox();
  if (!box) {
    throw new Error("the map has no box");
  }
  // Houses stand on both sides of the street, which runs north-east.
  await walker.page.mouse.click(box.x + box.width / 2 - 45, box.y + box.height / 2 - 15);
  await expect(walker.page.getByText("inside of a building")).toBeVisible();
  await walker.sees("final");
  const there = await walker.pose();
  expect(buildings.contain(there.eye[0], there.eye[1])).toBe(false);
  const nearest = catalogue.nearest(there.eye);
  expect(nearest && distance(placeOf(nearest), there.eye)).toBeLessThan(0.01);
  await keep("map_into_building");

  // Across the street, as fast as one can, for longer than it is wide.
  await walker.open(linkTo(server.url, { ...there, headingDeg: (0.61 * 180) / Math.PI + 90 }));
  await walker.page.keyboard.down("Shift");
  await walker.hold("w", 4000);
  await walker.page.keyboard.up("Shift");
  await walker.sees("final");
  const { eye } = await walker.pose();
  expect(distance(eye, there.eye)).toBeGreaterThan(1);
  expect(buildings.contain(eye[0], eye[1])).toBe(false);
  await keep("before_wall");
});

/** Goes a way to the north by the keys of the map alone. */
async function leadsByKeys(walker: Walker): Promise<void> {
  const { page } = walker;
  const map = page.getByRole("application", { name: /^Map\./ });
  const start = await walker.pose();
  await expect(async () => {
    await page.keyboard.press("Tab");
    await expect(map).toBeFocused({ timeout: 50 });
  }).toPass();
  for (const key of ["+", "ArrowUp", "ArrowUp", "ArrowUp", "ArrowRight"]) {
    await page.keyboard.press(key);
  }
  await expect(page.locator(".inset-map .cross")).toHaveCSS("opacity", "1");
  // What lies in the middle is said.
  await expect(page.locator(".inset-map [role=status]")).toHaveText(
    /^In the middle of the map: \d.* m north(-east)? away/,
  );
  await page.keyboard.press("Enter");
  await expect.poll(async () => (await walker.pose()).eye[1]).toBeGreaterThan(start.eye[1] + 5);
  await walker.sees("final");
  expect((await walker.pose()).headingDeg).toBe(start.headingDeg);
  // The arrows are the street's again.
  await page.keyboard.press("Escape");
  await expect(walker.stage).toBeFocused();
}

test("the map can be used by keys alone", async ({ server, walker, keep }) => {
  await walker.open(server.url);
  await expect(walker.page.locator(".inset-map canvas")).toBeVisible();
  await leadsByKeys(walker);
  await walker.page.keyboard.press("Shift+Tab");
  await keep("map_by_keys");
});

test("a tap of a key is a step, however short", async ({ server, walker }) => {
  await walker.open(server.url);
  const before = await walker.pose();
  // Down and up again before the screen is drawn.
  await walker.stage.evaluate((stage) => {
    for (const type of ["keydown", "keyup"]) {
      stage.dispatchEvent(new KeyboardEvent(type, { code: "KeyW", key: "w", bubbles: true }));
    }
  });
  const gone = async () => distance((await walker.pose()).eye, before.eye);
  await expect.poll(gone).toBeGreaterThan(0.04);
  expect(await gone()).toBeLessThan(0.6);
  await walker.sees("final");
});

test("where the browser lets no page copy, the link can be copied by hand", async ({
  server,
  walker,
  keep,
}) => {
  const { page } = walker;
  // As on plain http away from this machine.
  await page.addInitScript(() =>
    Object.defineProperty(navigator, "clipboard", { value: undefined }),
  );
  await walker.open(server.url);
  await walker.pose();
  await page.getByRole("button", { name: "Copy a link" }).click();
  const field = page.getByRole("textbox", { name: "To be copied" });
  await expect(field).toBeFocused();
  await expect(field).toHaveValue(page.url());
  const selected = () =>
    field.evaluate((area: HTMLTextAreaElement) =>
      area.value.slice(area.selectionStart, area.selectionEnd),
    );
  expect(await selected()).toBe(page.url());
  await keep("copied_by_hand");
  await page.keyboard.press("Control+c");
  await expect(field).toHaveCount(0);
});

test("a link to nowhere leads to the street's beginning, and says so", async ({
  server,
  walker,
}) => {
  for (const at of ["1e300,6861077,44", "0,0,0"]) {
    // It is said at once, and not for ever: a slow machine's whole picture may come after it has gone.
    await walker.page.goto(`${server.url}/?scene=sample&at=${at}&look=39`);
    await expect(walker.page.getByText("leads outside of this street")).toBeVisible();
    await walker.sees("final");
    const { eye } = await walker.pose();
    expect(eye[0]).toBeGreaterThan(650_000);
    expect(walker.page.url().length).toBeLessThan(160);
  }
});

test("the page has its usual address, too, and what is not there is not found", async ({
  server,
  request,
}) => {
  const page = await request.get(`${server.url}/`);
  const index = await request.get(`${server.url}/index.html`);
  expect(await index.text()).toBe(await page.text());
  expect(index.headers()["content-type"]).toContain("text/html");
  for (const path of ["/assets/gone.js", "/favicon.ico", "/street/a"]) {
    expect((await request.get(server.url + path)).status(), path).toBe(404);
  }
});

/** Whether nothing lies over these, and they end within a screen that is 360 wide. */
async function allInSight(elements: Locator): Promise<void> {
  for (const one of await elements.all()) {
    const box = await one.boundingBox();
    expect(box?.x ?? -1).toBeGreaterThanOrEqual(0);
    expect((box?.x ?? 999) + (box?.width ?? 999)).toBeLessThanOrEqual(360);
    const isOnTop = await one.evaluate((it) => {
      const { left, top, width, height } = it.getBoundingClientRect();
      const met = document.elementFromPoint(left + width / 2, top + height / 2);
      return met !== null && it.contains(met);
    });
    expect(isOnTop, (await one.textContent()) ?? "").toBe(true);
  }
}

test("works on a narrow screen, and with fingers", async ({ server, browser }) => {
  const context = await browser.newContext({
    viewport: { width: 360, height: 640 },
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
  await allInSight(walker.page.locator(".layers > label, .more-button"));
  await walker.page.getByRole("button", { name: "Measure" }).tap();
  const panel = walker.page.getByRole("region", { name: "Measure" });
  await walker.page.touchscreen.tap(30, 330);
  await expect(panel.locator(".line")).toHaveText(/^\d+\.\d+, \d+\.\d+, \d+\.\d+$/);
  await walker.page.touchscreen.tap(120, 480);
  await expect(panel.locator(".line")).toHaveText(/^\d+\.\d+ m ± /);
  // One line: what was tapped stays in sight.
  expect((await panel.boundingBox())?.height).toBeLessThan(60);
  await allInSight(walker.status);
  await walker.page.screenshot({ path: path.join(PICTURES, "narrow_line.png") });
  await panel.getByRole("button", { name: "Details" }).tap();
  await expect(panel.getByText("WGS84").first()).toBeVisible();
  await allInSight(walker.status);
  await walker.page.screenshot({ path: path.join(PICTURES, "narrow_measure.png") });
  await walker.page.getByRole("button", { name: "Measure" }).tap();
  const start = await walker.pose();
  // A tap on the road ahead goes there.
  await walker.page.touchscreen.tap(180, 450);
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

test("what is measured stays in sight, on whatever screen", async ({ server, browser }) => {
  for (const [width, height] of [
    [768, 1024],
    [640, 360],
    [1024, 768],
  ] as const) {
    const size = `${width}x${height}`;
    const context = await browser.newContext({ viewport: { width, height }, hasTouch: true });
    const walker = new Walker(await context.newPage());
    await walker.open(server.url);
    await walker.page.getByRole("button", { name: "Measure" }).tap();
    const panel = walker.page.getByRole("region", { name: "Measure" });
    // To the right, where a panel would be, and low, where the road is.
    for (const [x, y] of [
      [width * 0.72, height * 0.4],
      [width * 0.6, height * 0.78],
    ] as const) {
      await walker.page.touchscreen.tap(x, y);
      await expect(panel.getByText("Asking")).toHaveCount(0);
      await expect(panel.getByText("WGS84").last(), size).toBeAttached();
      const met = await walker.page.evaluate(
        ([x, y]) => document.elementFromPoint(x, y)?.closest(".stage") !== null,
        [x, y] as const,
      );
      expect(met, `${size}: the panel hides ${x}, ${y}`).toBe(true);
    }
    await expect(panel.locator(".line"), size).toHaveText(/^\d+\.\d+ m/);
    await walker.page.screenshot({ path: path.join(PICTURES, `measured_${size}.png`) });
    await context.close();
  }
});

test("says where nothing is in sight, and leads back", async ({ server, walker, keep }) => {
  await walker.open(server.url);
  const start = await walker.pose();
  const [x, y, z] = start.eye;
  const back = walker.page.getByRole("button", { name: "Back to the street" });
  // The sky over the street is in order.
  await walker.open(linkTo(server.url, { ...start, pitchDeg: 89 }));
  await expect(back).toBeHidden();
  for (const [eye, pitchDeg] of [
    [[x, y, z + 4000], 0],
    [[x + 8000, y, z], 0],
  ] as const) {
    await walker.open(linkTo(server.url, { ...start, eye, pitchDeg }));
    await expect(walker.page.getByText("Nothing of this street is in sight")).toBeVisible();
    await keep("astray");
    await back.click();
    // The street comes into sight before one has arrived.
    await expect.poll(async () => (await walker.pose()).eye).toEqual(start.eye);
    await walker.sees("final");
    await expect(back).toBeHidden();
  }
});

test("what changes with each frame is not read aloud", async ({ server, walker }) => {
  await walker.open(server.url);
  await expect(walker.spoken).toHaveText("Final");
  await walker.spoken.evaluate((region) => {
    const said: string[] = [];
    Object.assign(window, { said });
    new MutationObserver(() => said.push(region.textContent ?? "")).observe(region, {
      childList: true,
      characterData: true,
      subtree: true,
    });
  });
  await walker.status.evaluate((status) => {
    // How often one state lasted for nearly as long as something new has to before it is said.
    let [since, stretches] = [performance.now(), 0];
    const turn = () => {
      stretches += performance.now() - since > 900 ? 1 : 0;
      since = performance.now();
      return stretches;
    };
    Object.assign(window, { turn });
    let before = status.dataset.quality;
    new MutationObserver(() => {
      if (status.dataset.quality !== before) {
        before = status.dataset.quality;
        turn();
      }
    }).observe(status, { attributeFilter: ["data-quality"] });
  });
  for (const key of ["w", "ArrowRight", "w"]) {
    await walker.hold(key, 500);
    await walker.sees("final");
  }
  // As long as something new has to last before it is said.
  await walker.page.waitForTimeout(1200);
  const said = await walker.page.evaluate(() => (window as unknown as { said: string[] }).said);
  expect(said.filter((text) => text !== "Loading" && text !== "Final")).toEqual([]);
  const lasted = await walker.page.evaluate(() =>
    (window as unknown as { turn: () => number }).turn(),
  );
  expect(said.length).toBeLessThanOrEqual(lasted);
  await expect(walker.page.locator(".status [aria-live], .panel .body[aria-live]")).toHaveCount(0);
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
  // Where Enter acts is shown as long as it does.
  const reticle = page.locator(".reticle");
  await walker.stage.focus();
  await expect(reticle).toHaveCSS("opacity", "0.9");
  await page.keyboard.press("Tab");
  await expect(reticle).toHaveCSS("opacity", "0");
  await walker.stage.focus();
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

test("the rarer layers can be chosen by keys alone", async ({ server, walker }) => {
  await walker.open(server.url);
  const { page } = walker;
  const more = page.getByRole("button", { name: "More" });
  const option = (name: string) => page.getByRole("radio", { name });
  await more.focus();
  await page.keyboard.press("Enter");
  await expect(option("Point colours")).toBeFocused();
  await page.keyboard.press("ArrowDown");
  await expect(option("Wireframe")).toBeChecked();
  await expect(more).toHaveAttribute("aria-expanded", "true");
  await page.keyboard.press("Escape");
  await expect(more).toBeFocused();
  await expect(more).toHaveAttribute("aria-expanded", "false");
  // What was chosen is where one goes on, and what is left closes.
  await page.keyboard.press("Space");
  await expect(option("Wireframe")).toBeFocused();
  await page.keyboard.press("Tab");
  await expect(more).toHaveAttribute("aria-expanded", "false");
});

test("has a heading, as pages do, and one can see that there is more", async ({
  server,
  walker,
}) => {
  await walker.open(server.url);
  await expect(walker.page.getByRole("heading", { level: 1 })).toHaveText("sample · Flaneur");
  const dots = walker.page.locator(".more-button path");
  expect(await dots.evaluate((path: SVGPathElement) => path.getBBox().height)).toBeGreaterThan(1);
});

test("who wants nothing to move still sees that something is under way", async ({
  server,
  walker,
}) => {
  const { page } = walker;
  await page.emulateMedia({ reducedMotion: "reduce" });
  await page.route("**/flaneur.v1.RenderService/Watch", () => {});
  await page.goto(server.url);
  const bar = page.locator(".progress .bar");
  await expect(bar).toBeAttached();
  const wide = () => bar.evaluate((it) => it.getBoundingClientRect());
  await expect.poll(async () => (await wide()).width).toBeGreaterThan(1000);
  expect((await wide()).left).toBe(0);
  // So long a click is felt, milliseconds.
  await walker.stage.evaluate((stage) => {
    new MutationObserver((changes) => {
      const isRing = (node: Node) => node instanceof Element && node.matches(".pulse");
      for (const { addedNodes, removedNodes } of changes) {
        if ([...addedNodes].some(isRing)) {
          stage.dataset.felt = String(performance.now());
        } else if ([...removedNodes].some(isRing)) {
          stage.dataset.feltMs = String(performance.now() - Number(stage.dataset.felt));
        }
      }
    }).observe(stage, { childList: true });
  });
  await walker.click([512, 500]);
  await expect(walker.stage).toHaveAttribute("data-felt-ms", /\d/);
  const felt = await walker.stage.evaluate((stage) => Number(stage.dataset.feltMs));
  expect(felt).toBeGreaterThan(300);
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
  await expect(walker.page.locator(".inset-map .drawn svg")).toBeVisible();
  expect((await walker.colours()).spread).toBeGreaterThan(20);
  await keep("without_webgl");
  await leadsByKeys(walker);
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
