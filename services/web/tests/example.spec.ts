import { execFile } from "node:child_process";
import fs from "node:fs";
import path from "node:path";
import { promisify } from "node:util";
import { ROOT } from "./support/place";
import { expect, test } from "./support/test";

test("the example in TypeScript walks", async ({ server }) => {
  const cwd = path.join(ROOT, "examples/typescript");
  const command = ["start", "--silent", "--", server.url, "sample"];
  const { stdout } = await promisify(execFile)("npm", command, { cwd });
  expect(stdout).toMatch(/^sample: EPSG:2154, \d+ photographs$/m);
  expect(stdout).toMatch(/^[1-9]\d* buildings within 50 m$/m);
  expect(stdout).toMatch(/^lidar: [1-9]\d* points/m);
  expect(stdout).toMatch(/^picture: \d{4,} bytes of image\/jpeg$/m);
  for (const step of [1, 2, 3]) {
    expect(stdout).toMatch(new RegExp(`^step ${step}: final`, "m"));
    const picture = path.join(cwd, `walk_${step}.jpg`);
    expect(fs.statSync(picture).size).toBeGreaterThan(10_000);
    fs.rmSync(picture);
  }
});
