import { execFileSync } from "node:child_process";
import fs from "node:fs";
import path from "node:path";
import { FLANEUR, MADE, ROOT, STORE, STREET } from "./place";

/** Half of the synthetic street: enough to walk, and soon made. */
const SCALE = "0.5";

/** The synthetic street and its store; made anew where they are older than what makes them. */
export function makeStreet(): void {
  const street = path.join(STREET, "street.toml");
  if (modified(street) < newest(path.join(ROOT, "sample/src"))) {
    fs.rmSync(MADE, { recursive: true, force: true });
    fs.mkdirSync(MADE, { recursive: true });
    execFileSync(FLANEUR, ["sample", STREET, "--scale", SCALE], { stdio: "ignore" });
  }
  // Does next to nothing where the store is up to date.
  execFileSync(FLANEUR, ["ingest", STREET, "--out", STORE], { stdio: "ignore" });
}

function modified(file: string): number {
  return fs.existsSync(file) ? fs.statSync(file).mtimeMs : 0;
}

function newest(folder: string): number {
  const files = fs.readdirSync(folder, { recursive: true, encoding: "utf8" });
  return Math.max(...files.map((file) => modified(path.join(folder, file))));
}
