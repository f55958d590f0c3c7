import path from "node:path";
import type { BrowserContext, Locator, Page } from "@playwright/test";
import { PICTURES } from "./support/place";
import { Server } from "./support/server";
import { expect, test } from "./support/test";
import { Walker } from "./support/walker";

/** Telephones and a tablet, CSS pixels. */
const SCREENS = [
  [360, 640],
  [640, 360],
  [768, 1024],
] as const;

/** What a finger hits, CSS pixels. */
const FINGER_PX = 40;

function keep(page: Page, name: string): Promise<Buffer> {
  return page.screenshot({ path: path.join(PICTURES, `${name}.png`) });
}

/** Of what can be touched: what is outside of the screen, beneath something else, or too small. */
function faultsOf(page: Page, touchable: string, least = 0): Promise<string[]> {
  return page.locator(touchable).evaluateAll((all, least) => {
    const faults: string[] = [];
    for (const one of all) {
      const { left, top, right, bottom, width, height } = one.getBoundingClientRect();
      if (!one.checkVisibility({ visibilityProperty: true })) {
        continue;
      }
      const name = one.getAttribute("aria-label") ?? one.textContent ?? one.tagName;
      if (left < 0 || top < 0 || right > innerWidth || bottom > innerHeight) {
        faults.push(`${name} is outside`);
      }
      const met = document.elementFromPoint((left + right) / 2, (top + bottom) / 2);
      if (!one.contains(met)) {
        faults.push(`${name} is beneath ${met?.className}`);
      }
      if (width < least || height < least) {
        faults.push(`${name} is ${width} x ${height}`);
      }
    }
    return faults;
  }, least);
}

type Box = Awaited<ReturnType<Locator["boundingBox"]>>;

/** Whether two boxes, both on the screen, share a part of it. */
function overlaps(one: Box, other: Box): boolean {
  if (!one || !other) {
    throw new Error("not on the screen");
  }
  return (
    one.x < other.x + other.width &&
    other.x < one.x + one.width &&
    one.y < other.y + other.height &&
    other.y < one.y + one.height
  );
}

/** Puts a place near the middle of the screen on the tape. */
async function measureAhead(walker: Walker, [x, y]: readonly [number, number]): Promise<Locator> {
  await walker.page.getByRole("button", { name: "Measure" }).click();
  await walker.click([x, y]);
  const panel = walker.page.getByRole("region", { name: "Measure" });
  await expect(panel.locator(".line")).toHaveText(/^\d+\.\d+, \d+/);
  return panel;
}

async function touched(
  browser: { newContext(options: object): Promise<BrowserContext> },
  [width, height]: readonly [number, number],
): Promise<Walker> {
  const context = await browser.newContext({
    viewport: { width, height },
    hasTouch: true,
    isMobile: true,
    permissions: ["clipboard-read", "clipboard-write"],
  });
  return new Walker(await context.newPage());
}

for (const screen of SCREENS) {
  const size = screen.join("x");

  test(`every tool can be hit with a finger on ${size}`, async ({ server, browser }) => {
    const walker = await touched(browser, screen);
    const { page } = walker;
    await walker.open(server.url);
    const map = page.getByRole("button", { name: "Map", exact: true });
    if ((await map.getAttribute("aria-pressed")) === "false") {
      await map.tap();
    }
    const corner = page.getByRole("region", { name: "Map" });
    await expect(corner).toBeVisible();
    const tools = ".top button, .top select, .end button, .map-zoom button";
    // The names of layers lie side by side: so wide as they are.
    const switches = ".layers > label";
    expect(await faultsOf(page, tools, FINGER_PX)).toEqual([]);
    expect(await faultsOf(page, switches, FINGER_PX)).toEqual([]);
    // With its legend, and what lies over it, every layer can be chosen, and the map stays where it is.
    const before = await corner.boundingBox();
    for (const name of ["Uncertainty", "Point colours", "Wireframe", "Depth", "Normals"]) {
      if (name !== "Uncertainty") {
        await page.locator(".more-button").tap();
        expect(await faultsOf(page, ".more-layers label", FINGER_PX), name).toEqual([]);
      }
      await page.getByRole("radio", { name }).tap();
      await expect(page.locator(".legend strong")).toHaveText(name);
      expect(await faultsOf(page, `${tools}, ${switches}, .legend`), name).toEqual([]);
      const now = await corner.boundingBox();
      expect(now?.x, name).toBe(before?.x);
      expect(now?.y, name).toBe(before?.y);
    }
    await walker.sees("final");
    await keep(page, `layers_${size}`);
    await page.context().close();
  });

  test(`a photograph is shown large on ${size}, and its street afterwards`, async ({
    server,
    browser,
  }) => {
    const walker = await touched(browser, screen);
    const { page } = walker;
    const [width, height] = screen;
    await walker.open(server.url);
    const panel = await measureAhead(walker, [width * 0.3, height * 0.45]);
    await panel.getByRole("button", { name: "Details" }).tap();
    await page.getByText(/photographs? see/).tap();
    expect(await faultsOf(page, ".panel header button, .sights li:first-child button")).toEqual([]);
    await page.locator(".sight").first().tap();
    const dialog = page.getByRole("dialog", { name: /^Photograph/ });
    await expect(dialog.getByRole("img")).toBeVisible();
    const shown = await dialog.locator(".upright").boundingBox();
    expect(Math.max((shown?.width ?? 0) / width, (shown?.height ?? 0) / height)).toBeGreaterThan(
      0.8,
    );
    expect(await faultsOf(page, "dialog[open] button", FINGER_PX)).toEqual([]);
    await keep(page, `photograph_${size}`);
    await dialog.getByRole("button", { name: "Go to where it was taken" }).tap();
    await expect(dialog).toBeHidden();
    // What was gone for is not behind the panel.
    await expect(panel.locator(".body")).toBeHidden();
    await walker.sees("final");
    await keep(page, `taken_${size}`);
    await page.context().close();
  });
}

test("the map and the tape, which share a place, are never both said to be there", async ({
  server,
  browser,
}) => {
  const walker = await touched(browser, [360, 640]);
  const { page } = walker;
  await walker.open(server.url);
  const map = page.getByRole("button", { name: "Map", exact: true });
  const measure = page.getByRole("button", { name: "Measure" });
  const corner = page.locator(".inset-map");
  const panel = page.locator(".measure-panel");
  const isPressed = async (button: Locator, pressed: boolean) =>
    expect(button).toHaveAttribute("aria-pressed", String(pressed));
  await map.tap();
  await expect(corner).toBeVisible();
  await measure.tap();
  await expect(panel).toBeVisible();
  await expect(corner).toBeHidden();
  await isPressed(map, false);
  await map.tap();
  await expect(corner).toBeVisible();
  await expect(panel).toBeHidden();
  await isPressed(map, true);
  await isPressed(measure, false);
  await map.tap();
  await measure.tap();
  await map.tap();
  await expect(corner).toBeVisible();
  await isPressed(map, true);
  await page.context().close();
});

for (const screen of [
  [360, 740],
  [640, 360],
] as const) {
  const size = screen.join("x");

  test(`what was measured is there again after a look at the map on ${size}`, async ({
    server,
    browser,
  }) => {
    const walker = await touched(browser, screen);
    const { page } = walker;
    const [width, height] = screen;
    await walker.open(server.url);
    const map = page.getByRole("button", { name: "Map", exact: true });
    const measure = page.getByRole("button", { name: "Measure" });
    const corner = page.locator(".inset-map");
    const ends = page.locator(".ruler circle:not(.casing)");
    const panel = await measureAhead(walker, [width * 0.3, height * 0.45]);
    const line = panel.locator(".line");
    // The map is opened before the server has said what was clicked.
    const asked = page.waitForRequest(/\/Pick$/);
    await walker.click([width * 0.6, height * 0.7]);
    await asked;
    await map.tap();
    await expect(corner).toBeVisible();
    await expect(page.locator(".measure-panel")).toBeHidden();
    await expect(ends).toHaveCount(2);
    await keep(page, `map_measured_${size}`);
    await map.tap();
    await expect(corner).toBeHidden();
    await expect(line).toHaveText(/^\d+\.\d+ m/);
    await expect(measure).toHaveAttribute("aria-pressed", "true");
    const said = await panel.textContent();
    await map.tap();
    await expect(panel).toBeHidden();
    await measure.tap();
    await expect(panel).toBeVisible();
    await expect(corner).toBeHidden();
    expect(await panel.textContent()).toBe(said);
    await expect(ends).toHaveCount(2);
    // A third click begins anew, and what is put away is gone.
    await walker.click([width * 0.3, height * 0.45]);
    await expect(ends).toHaveCount(1);
    await measure.tap();
    await expect(ends).toHaveCount(0);
    await page.context().close();
  });
}

test("what a finger has touched does not stay marked", async ({ server, browser }) => {
  const walker = await touched(browser, [360, 640]);
  await walker.open(server.url);
  const link = walker.page.getByRole("button", { name: "Copy a link" });
  await link.tap();
  await expect(walker.page.getByText("Link copied")).toBeVisible();
  await expect(link).toHaveCSS("background-color", "rgba(0, 0, 0, 0)");
  await walker.page.context().close();
});

test("words in passing take the width that there is", async ({ server, browser }) => {
  const walker = await touched(browser, [360, 640]);
  await walker.page.goto(`${server.url}/?scene=sample&at=0,0,0&look=0`);
  const words = walker.page.getByText("leads outside of this street");
  await expect(words).toBeVisible();
  expect((await words.boundingBox())?.width).toBeGreaterThan(300);
  await walker.page.context().close();
});

test("words in passing leave an opened panel in sight", async ({ server, browser }) => {
  for (const screen of [
    [360, 740],
    [600, 340],
    [640, 360],
    [932, 430],
  ] as const) {
    const [width, height] = screen;
    const size = screen.join("x");
    const walker = await touched(browser, screen);
    const { page } = walker;
    await walker.open(server.url);
    const panel = await measureAhead(walker, [width * 0.7, height * 0.55]);
    await panel.getByRole("button", { name: "Details" }).tap();
    await page.getByRole("button", { name: "Copy a link" }).tap();
    await expect(page.getByText("Link copied"), size).toBeVisible();
    // What went wrong may take more words; none of them waits for the test.
    const words = await page.locator(".toast").evaluate((it) =>
      ["Link copied", "What the server says of what went wrong. ".repeat(3)].map((text) => {
        it.textContent = text;
        return it.getBoundingClientRect().toJSON();
      }),
    );
    await keep(page, `words_${size}`);
    const there = await panel.boundingBox();
    for (const box of words) {
      expect(box.left, size).toBeGreaterThanOrEqual(0);
      expect(box.right, size).toBeLessThanOrEqual(width);
      expect(overlaps(box, there), `${size}: over the panel`).toBe(false);
    }
    await page.context().close();
  }
});

test("the panel can be read beside what is said of a lost connection", async ({ browser }) => {
  const server = await Server.start();
  try {
    const walker = await touched(browser, [640, 360]);
    await walker.open(server.url);
    await server.kill();
    await walker.sees("lost");
    await walker.page.getByRole("button", { name: "Measure" }).tap();
    const panel = walker.page.getByRole("region", { name: "Measure" });
    await expect(panel).toBeVisible();
    expect((await panel.boundingBox())?.width).toBeGreaterThan(250);
    expect(await faultsOf(walker.page, ".panel button, .status button", 28)).toEqual([]);
    await keep(walker.page, "lost_640x360");
    await walker.page.context().close();
  } finally {
    await server.kill();
  }
});

test("names of scenes leave the tools their room", async ({ server, browser }) => {
  for (const width of [620, 700, 770, 820, 1010]) {
    const context = await browser.newContext({ viewport: { width, height: 700 } });
    const page = await context.newPage();
    await page.goto(`${server.url}/?layer=colours`);
    const scene = page.locator(".scene");
    await expect(scene).toBeVisible();
    await scene.evaluate((it) => it.replaceChildren("a street whose name is long, very long"));
    expect(await faultsOf(page, ".top button, .layers > label"), String(width)).toEqual([]);
    await context.close();
  }
});

test("the photograph's window on a wide screen is as wide as the photograph", async ({
  server,
  walker,
  keep,
}) => {
  const { page } = walker;
  await page.setViewportSize({ width: 1280, height: 720 });
  await walker.open(server.url);
  const panel = await measureAhead(walker, [400, 300]);
  await walker.click([700, 560]);
  await expect(panel.locator("[data-figure=distance]")).toBeVisible();
  // Of the photographs that see a place as many are in sight as there is room for.
  await panel
    .getByText(/photographs? see/)
    .first()
    .click();
  const [inside, first] = [panel.locator(".body"), panel.locator(".sights").first()];
  const room = await inside.boundingBox();
  const rows = await first
    .locator("li")
    .evaluateAll(
      (all, bottom) => all.filter((row) => row.getBoundingClientRect().bottom <= bottom + 1).length,
      (room?.y ?? 0) + (room?.height ?? 0),
    );
  expect(rows).toBeGreaterThanOrEqual(Math.min(5, await first.locator("li").count()));
  await first.getByRole("button").first().click();
  const dialog = page.getByRole("dialog", { name: /^Photograph/ });
  await expect(dialog.getByRole("img")).toBeVisible();
  const [around, picture] = [
    await dialog.boundingBox(),
    await dialog.locator(".upright").boundingBox(),
  ];
  expect((around?.width ?? 0) - (picture?.width ?? 0)).toBeLessThan(40);
  await keep("photograph_wide");
});
