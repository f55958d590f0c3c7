import { expect, type Locator, type Page } from "@playwright/test";
import type { ScreenPoint } from "../../src/controls/steering";
import { readLink } from "../../src/state/url";
import type { Pose } from "../../src/view/pose";

/** So long after the last step the whole picture has been asked for, milliseconds, ... */
const ASKED_MS = 100;
/** ... and the address has followed. */
const LINK_MS = 350;

/** A person before the page. */
export class Walker {
  readonly page: Page;
  readonly stage: Locator;
  readonly status: Locator;
  /** What is read aloud of it. */
  readonly spoken: Locator;

  constructor(page: Page) {
    this.page = page;
    this.stage = page.locator(".stage");
    this.status = page.locator(".status");
    this.spoken = this.status.getByRole("status");
  }

  /** Opens an address and waits for the whole picture. */
  async open(url: string): Promise<void> {
    await this.page.goto(url);
    await expect(this.status).toBeVisible({ timeout: 10_000 });
    await this.sees("final");
  }

  /** Has the page look for its server now, unless it has found it by itself meanwhile. */
  async tryNow(): Promise<void> {
    const button = this.page.getByRole("button", { name: "Try now" });
    await button.click({ timeout: 5000 }).catch(async (error: unknown) => {
      if (await button.isVisible()) {
        throw error;
      }
    });
  }

  /** Waits until the picture is as good as that, after what was done before has had its effect. */
  async sees(quality: string): Promise<void> {
    await this.#steps(ASKED_MS);
    await expect(this.status).toHaveAttribute("data-quality", quality, { timeout: 60_000 });
  }

  /** Does something that needs another picture, and waits until it has been asked for. */
  async asks(act: () => Promise<void>): Promise<void> {
    const asked = () => this.stage.evaluate((stage) => Number(stage.dataset.sequence));
    const before = await asked();
    await act();
    await expect.poll(asked).toBeGreaterThan(before);
  }

  /** Where the address says one is, once nothing moves any more. */
  async pose(): Promise<Pose> {
    // The street is drawn with every step: nothing was drawn, and the address has followed.
    const drawn = () => this.stage.evaluate((stage) => stage.dataset.drawn);
    await this.stage.evaluate((stage) => {
      if (stage.dataset.drawn === undefined) {
        stage.dataset.drawn = "";
        stage.addEventListener("flaneur:shown", (event) => {
          stage.dataset.drawn = JSON.stringify((event as CustomEvent).detail.pose);
        });
      }
    });
    let address = "";
    await expect
      .poll(
        async () => {
          const before = await drawn();
          address = await this.#steps(LINK_MS);
          return before === (await drawn());
        },
        { intervals: [0] },
      )
      .toBe(true);
    const { pose } = readLink(new URL(address).search);
    if (!pose) {
      throw new Error(`${address} says no pose`);
    }
    return pose;
  }

  /**
   * Lets the page draw, and so long pass by its own clock, which is behind that of the test where the
   * machine is busy. Says its address then.
   */
  #steps(ms: number): Promise<string> {
    return this.page.evaluate(async (ms) => {
      const after = (ms: number) => new Promise((resolve) => setTimeout(resolve, ms));
      const frame = () => new Promise((resolve) => requestAnimationFrame(resolve));
      // A page in the background may not be drawn.
      const frames = () => Promise.race([frame().then(frame), after(2000)]);
      await frames();
      await after(ms);
      await frames();
      return location.href;
    }, ms);
  }

  /** The newest picture as it came, as a PNG in base 64. */
  picture(): Promise<string> {
    return this.stage.evaluate((stage) => {
      const newest = [...stage.querySelectorAll<HTMLCanvasElement>("canvas.picture")].pop();
      return newest?.toDataURL().split(",")[1] ?? "";
    });
  }

  /** How far the newest picture is from another one, root mean square, of 255. */
  async differs(picture: string): Promise<number> {
    const own = await this.picture();
    return this.page.evaluate(
      async (pictures) => {
        const pixels = async (data: string) => {
          const bytes = Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0));
          const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
          const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
          context?.drawImage(bitmap, 0, 0);
          return context?.getImageData(0, 0, bitmap.width, bitmap.height).data ?? [];
        };
        const [a = [], b = []] = await Promise.all(pictures.map(pixels));
        let squares = a.length === b.length ? 0 : Number.POSITIVE_INFINITY;
        for (let at = 0; at < a.length; at += 1) {
          squares += ((a[at] ?? 0) - (b[at] ?? 0)) ** 2;
        }
        return Math.sqrt(squares / Math.max(a.length, 1));
      },
      [own, picture],
    );
  }

  /** Drags the street from one place to another, as a hand does. */
  async drag(from: ScreenPoint, to: ScreenPoint): Promise<void> {
    const { mouse } = this.page;
    await mouse.move(...from);
    await mouse.down();
    await mouse.move(...to, { steps: 12 });
    await mouse.up();
  }

  /** Holds a key for so long, milliseconds. */
  async hold(key: string, ms: number): Promise<void> {
    await this.page.keyboard.down(key);
    await this.page.waitForTimeout(ms);
    await this.page.keyboard.up(key);
  }

  async click(at: ScreenPoint): Promise<void> {
    await this.page.mouse.click(...at);
  }

  /** Whether the newest picture fills the stage: no corner of it lies inside. */
  async coverage(): Promise<boolean> {
    return this.stage.evaluate((stage) => {
      const newest = [...stage.querySelectorAll(".picture")].pop();
      const [box, inner] = [stage.getBoundingClientRect(), newest?.getBoundingClientRect()];
      return (
        inner !== undefined &&
        inner.left <= box.left + 1 &&
        inner.top <= box.top + 1 &&
        inner.right >= box.right - 1 &&
        inner.bottom >= box.bottom - 1
      );
    });
  }

  /** Mean and spread of the colours of what is on the screen, from 0 to 255: a blank has no spread. */
  async colours(): Promise<{ mean: number; spread: number }> {
    const png = await this.stage.screenshot();
    return this.page.evaluate(async (data) => {
      const bytes = Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0));
      const file = new Blob([bytes], { type: "image/png" });
      const bitmap = await createImageBitmap(file);
      const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
      const context = canvas.getContext("2d");
      context?.drawImage(bitmap, 0, 0);
      const pixels = context?.getImageData(0, 0, bitmap.width, bitmap.height).data ?? [];
      let [sum, squares, count] = [0, 0, 0];
      for (let at = 0; at < pixels.length; at += 4) {
        const value = ((pixels[at] ?? 0) + (pixels[at + 1] ?? 0) + (pixels[at + 2] ?? 0)) / 3;
        sum += value;
        squares += value * value;
        count += 1;
      }
      const mean = sum / count;
      return { mean, spread: Math.sqrt(squares / count - mean * mean) };
    }, png.toString("base64"));
  }
}
