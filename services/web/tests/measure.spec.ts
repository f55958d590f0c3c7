import { distance, planDistance, type Vector3 } from "../src/geometry/vector";
import { findPixels, linkTo } from "./support/places";
import { expect, test } from "./support/test";
import { trueViews } from "./support/truth";

/** What the issue of a measurement may be off, metres. */
const TOLERANCE_M = 0.05;

test("measures between places of the street, as they truly are", async ({
  server,
  walker,
  keep,
}) => {
  const { page } = walker;
  const walls = findPixels(trueViews(), ({ place, up }, view) => {
    const above = place[2] - view.pose.eye[2];
    return Math.abs(up) < 0.05 && above > 0.3 && planDistance(place, view.pose.eye) < 12;
  });
  const [from] = walls;
  const to = walls.find(
    (wall) => from && wall.view === from.view && distance(wall.place, from.place) > 2,
  );
  if (!from || !to) {
    throw new Error("no view shows two such places");
  }
  await walker.open(linkTo(server.url, from.view.pose));
  await page.getByRole("button", { name: "Measure" }).click();
  const panel = page.getByRole("region", { name: "Measure" });
  await walker.click(from.at);
  await expect(panel.getByText("WGS84")).toBeVisible();
  const said = async (index: number): Promise<Vector3> => {
    const text = await panel.locator("[data-figure=position]").nth(index).textContent();
    const [x = 0, y = 0, z = 0] = (text ?? "").split(", ").map(Number);
    return [x, y, z];
  };
  expect(distance(await said(0), from.place)).toBeLessThan(TOLERANCE_M);
  // One place says where it is, from what it is known, when it was seen, and how surely.
  for (const row of ["Measured on", "Uncertainty", "Photograph"]) {
    await expect(panel.getByText(row, { exact: true }).first()).toBeVisible();
  }
  await expect(panel).toContainText("RGF93 / Lambert-93 (EPSG:2154)");
  await walker.click(to.at);
  const figure = panel.locator("[data-figure=distance]");
  await expect(figure).toBeVisible();
  expect(distance(await said(1), to.place)).toBeLessThan(TOLERANCE_M);
  const measured = Number.parseFloat((await figure.textContent()) ?? "");
  expect(Math.abs(measured - distance(from.place, to.place))).toBeLessThan(TOLERANCE_M);
  await expect(page.locator(".ruler line")).toHaveCount(2);
  await keep("measured");

  // A button says that it has copied, and then again what it copies.
  const copy = panel.getByRole("button", { name: "Copy the position" }).first();
  await copy.click();
  const copied = panel.getByRole("button", { name: "Copied" });
  await expect(copied).toHaveCount(1);
  await expect(copied).toHaveCount(0);
  await expect(panel.getByRole("button", { name: "Copy the position" })).toHaveCount(2);

  // The photographs that see a place can be opened.
  const list = panel.getByText(/photographs? see/).first();
  await list.click();
  await panel.locator(".sight").first().click();
  const dialog = page.getByRole("dialog", { name: /^Photograph/ });
  const photograph = dialog.getByRole("img");
  await expect(photograph).toBeVisible();
  expect(
    await photograph.evaluate((image: HTMLImageElement) => image.naturalWidth),
  ).toBeGreaterThan(100);
  await expect(dialog.locator(".mark")).toBeVisible();
  await keep("photograph");
  await page.keyboard.press("Escape");
  await expect(dialog).toBeHidden();
});

test("says of a lidar point what class it has, and when it was measured", async ({
  server,
  walker,
  keep,
}) => {
  const { page } = walker;
  const road = findPixels(trueViews(), ({ place, up }, view) => {
    return up > 0.95 && planDistance(place, view.pose.eye) < 12;
  });
  const [first] = road;
  if (!first) {
    throw new Error("no view shows the road");
  }
  const at = road.filter(({ view }) => view === first.view);
  await walker.open(linkTo(server.url, first.view.pose));
  await page.getByRole("button", { name: "Measure" }).click();
  const panel = page.getByRole("region", { name: "Measure" });
  // Between the points the road is known from the terrain.
  const moment = panel.locator("[data-figure=moment]").first();
  for (const place of at.slice(0, 30)) {
    await walker.click(place.at);
    await expect(panel.getByText("WGS84").first()).toBeVisible();
    await expect(panel.getByText("Asking")).toHaveCount(0);
    if (await moment.isVisible()) {
      break;
    }
    await panel.getByRole("button", { name: "Clear" }).click();
  }
  await expect(moment).toHaveText(/^2024-05-14 09:0\d:\d\d(\.\d{3})? UTC$/);
  await expect(panel).toContainText("adjusted standard GPS time");
  await expect(panel).toContainText(/ground, class 2|road surface, class 11/);
  await keep("lidar_point");
});
