import { expect, type Locator, type Page } from "@playwright/test";
import type { ScreenPoint } from "../../src/controls/steering";
import { readLink } from "../../src/state/url";
import type { Pose } from "../../src/view/pose";

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

  /** Waits until the picture is as good as that. */
  async sees(quality: string): Promise<void> {
    await expect(this.status).toHaveAttribute("data-quality", quality, { timeout: 60_000 });
  }

  /** Does something that needs another picture, and waits until it has been asked for. */
  async asks(act: () => Promise<void>): Promise<void> {
    const asked = () => this.stage.evaluate((stage) => Number(stage.dataset.sequence));
    const before = await asked();
    await act();
    await expect.poll(asked).toBeGreaterThan(before);
  }

  /** Where the address says one is, once it has been the same for a while. */
  async pose(): Promise<Pose> {
    let last = "";
    await expect
      .poll(
        async () => {
          const before = last;
          last = this.page.url();
          return before === last;
        },
        { intervals: [400] },
      )
      .toBe(true);
    const { pose } = readLink(new URL(last).search);
    if (!pose) {
      throw new Error(`${last} says no pose`);
    }
    return pose;
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
