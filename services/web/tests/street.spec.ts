import { connect } from "../src/api/clients";
import { shortTurn } from "../src/geometry/angles";
import { planDistance } from "../src/geometry/vector";
import { placeOf } from "../src/photographs/catalogue";
import { EYE_HEIGHT_M } from "../src/state/start";
import type { Pose } from "../src/view/pose";
import { findPixel, linkTo } from "./support/places";
import { expect, test } from "./support/test";
import { trueViews } from "./support/truth";

const SCENE = "sample";

test("opens on a photograph of the street, and the picture becomes final", async ({
  server,
  walker,
  keep,
}) => {
  await walker.open(server.url);
  const { panoramas } = connect(server.url);
  const pose = await walker.pose();
  let nearest = Number.POSITIVE_INFINITY;
  for await (const panorama of panoramas.streamPanoramas({ scene: SCENE })) {
    nearest = Math.min(nearest, planDistance(placeOf(panorama), pose.eye));
  }
  expect(nearest).toBeLessThan(0.01);
  expect((await walker.colours()).spread).toBeGreaterThan(20);
  await expect(walker.page).toHaveTitle("sample · Flaneur");
  await keep("opened");
});

test("looks around where one drags, zooms with the wheel", async ({ server, walker, keep }) => {
  await walker.open(server.url);
  const before = await walker.pose();
  await walker.drag([600, 400], [350, 450]);
  await walker.sees("final");
  const after = await walker.pose();
  // The street goes along with the hand: 250 pixels of a focal length of 603.
  expect(shortTurn(before.headingDeg, after.headingDeg)).toBeGreaterThan(18);
  expect(shortTurn(before.headingDeg, after.headingDeg)).toBeLessThan(26);
  expect(after.pitchDeg).toBeGreaterThan(before.pitchDeg + 3);
  expect(after.eye).toEqual(before.eye);
  await walker.page.mouse.wheel(0, -300);
  await walker.sees("final");
  expect((await walker.pose()).fovDeg).toBeLessThan(before.fovDeg * 0.75);
  await keep("zoomed");
});

test("walks with the keys, with the feet on the ground", async ({ server, walker, keep }) => {
  await walker.open(server.url);
  const before = await walker.pose();
  // A page that is seldom drawn makes fewer steps a second.
  await expect
    .poll(async () => {
      await walker.hold("w", 700);
      return planDistance((await walker.pose()).eye, before.eye);
    })
    .toBeGreaterThan(0.7);
  await walker.sees("final");
  const after = await walker.pose();
  const [dx, dy] = [after.eye[0] - before.eye[0], after.eye[1] - before.eye[1]];
  const heading = (Math.atan2(dx, dy) * 180) / Math.PI;
  expect(Math.hypot(dx, dy)).toBeLessThan(6);
  expect(Math.abs(shortTurn(before.headingDeg, heading))).toBeLessThan(1);
  // The street rises by less than 2 in 100.
  expect(Math.abs(after.eye[2] - before.eye[2])).toBeLessThan(0.2);
  await walker.hold("ArrowRight", 400);
  const turned = await walker.pose();
  expect(shortTurn(after.headingDeg, turned.headingDeg)).toBeGreaterThan(8);
  expect(turned.eye).toEqual(after.eye);
  await walker.sees("final");
  await keep("walked");
});

test("goes where one clicks the ground", async ({ server, walker }) => {
  const { view, place, at } = findPixel(trueViews(), ({ place, up }, view) => {
    const below = view.pose.eye[2] - place[2];
    const away = planDistance(place, view.pose.eye);
    return up > 0.95 && below > 1.4 && away > 4 && away < 15;
  });
  await walker.open(linkTo(server.url, view.pose));
  await walker.click(at);
  await walker.sees("final");
  await expect.poll(async () => planDistance((await walker.pose()).eye, place)).toBeLessThan(0.1);
  const pose = await walker.pose();
  expect(Math.abs(pose.eye[2] - place[2] - EYE_HEIGHT_M)).toBeLessThan(0.1);
  expect(pose.headingDeg).toBeCloseTo(view.pose.headingDeg, 1);
});

test("faces a wall that one clicks, and goes to a photograph with two clicks", async ({
  server,
  walker,
  keep,
}) => {
  // The street's axis, clockwise from north.
  const axis = (0.61 * 180) / Math.PI;
  const { view, at } = findPixel(trueViews(), ({ place, up }, view) => {
    const above = place[2] - view.pose.eye[2];
    const away = planDistance(place, view.pose.eye);
    return Math.abs(up) < 0.05 && above > 0.5 && above < 4 && away < 15;
  });
  await walker.open(linkTo(server.url, view.pose));
  await walker.click(at);
  await walker.sees("final");
  const across = async () => {
    const { headingDeg } = await walker.pose();
    return Math.min(
      Math.abs(shortTurn(headingDeg, axis + 90)),
      Math.abs(shortTurn(headingDeg, axis - 90)),
    );
  };
  await expect.poll(across).toBeLessThan(8);
  await walker.sees("final");
  await keep("wall");

  await walker.page.mouse.dblclick(512, 384);
  await walker.sees("final");
  const places: Pose["eye"][] = [];
  for await (const panorama of connect(server.url).panoramas.streamPanoramas({ scene: SCENE })) {
    places.push(placeOf(panorama));
  }
  const nearest = async () => {
    const { eye } = await walker.pose();
    return Math.min(...places.map((place) => planDistance(place, eye)));
  };
  await expect.poll(nearest).toBeLessThan(0.01);
});

test("switches what is shown, and says so in the link", async ({ server, walker, keep }) => {
  await walker.open(server.url);
  const street = await walker.colours();
  await walker.page.getByRole("radio", { name: "Uncertainty" }).check();
  await expect(walker.page).toHaveURL(/layer=uncertainty/);
  await walker.sees("final");
  await expect
    .poll(async () => Math.abs((await walker.colours()).mean - street.mean))
    .toBeGreaterThan(3);
  await expect(walker.page.getByText("How far the shown surface")).toBeVisible();
  await keep("uncertainty");
  await walker.page.getByRole("button", { name: "More" }).click();
  await walker.page.getByRole("radio", { name: "Normals" }).check();
  await expect(walker.page).toHaveURL(/layer=normals/);
  await walker.sees("final");
  const more = walker.page.getByRole("button", { name: "More" });
  await expect(more).toHaveText("Normals");
  // What was chosen is chosen: the street is free again. And Escape closes what was opened, wherever one is.
  await expect(more).toHaveAttribute("aria-expanded", "false");
  await more.click();
  await expect(more).toHaveAttribute("aria-expanded", "true");
  await walker.page.keyboard.press("Escape");
  await expect(more).toHaveAttribute("aria-expanded", "false");
  await expect(walker.page.getByText("Which way surfaces face").last()).toBeVisible();
  await keep("normals");
  await walker.page.keyboard.press("1");
  await expect(walker.page).not.toHaveURL(/layer/);
});

test("where the system chooses the colours one sees what is chosen", async ({ server, walker }) => {
  await walker.page.emulateMedia({ forcedColors: "active" });
  await walker.open(server.url);
  const ink = (name: string) =>
    walker.page
      .locator(".layers > label", { hasText: name })
      .locator("span")
      .evaluate((span) => getComputedStyle(span).color);
  expect(await ink("Street")).not.toBe(await ink("Mesh"));
});
