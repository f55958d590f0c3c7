import path from "node:path";
import { test as base } from "@playwright/test";
import { PICTURES } from "./place";
import { Server } from "./server";
import { Walker } from "./walker";

interface Things {
  readonly walker: Walker;
  /** Keeps a picture of the page, to be looked at. */
  readonly keep: (name: string) => Promise<void>;
}

interface Lasting {
  /** One for all tests of a file. */
  readonly server: Server;
}

export const test = base.extend<Things, Lasting>({
  server: [
    // biome-ignore lint/correctness/noEmptyPattern: Playwright wants to see what is asked for.
    async ({}, use) => {
      const server = await Server.start();
      await use(server);
      await server.kill();
    },
    { scope: "worker" },
  ],
  walker: async ({ page }, use) => {
    const faults: string[] = [];
    page.on("pageerror", (error) => faults.push(error.message));
    await use(new Walker(page));
    if (faults.length > 0) {
      throw new Error(`the page failed: ${faults.join("; ")}`);
    }
  },
  keep: async ({ page }, use) => {
    await use(async (name) => {
      await page.screenshot({ path: path.join(PICTURES, `${name}.png`) });
    });
  },
});

export { expect } from "@playwright/test";
