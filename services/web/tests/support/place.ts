import path from "node:path";
import { fileURLToPath } from "node:url";

/** The repository's root. */
export const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), "../../../..");
/** What the tests make. */
export const MADE = path.join(ROOT, "target/web-test");
export const STREET = path.join(MADE, "street");
export const STORE = path.join(MADE, "store");
export const PICTURES = path.join(MADE, "pictures");

/** The binary that is tested. */
export const FLANEUR = process.env.FLANEUR ?? path.join(ROOT, "target/release/flaneur");
