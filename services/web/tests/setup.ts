import fs from "node:fs";
import { PICTURES } from "./support/place";
import { makeStreet } from "./support/street";

/** Before the first test. */
export default function setUp(): void {
  makeStreet();
  fs.mkdirSync(PICTURES, { recursive: true });
}
