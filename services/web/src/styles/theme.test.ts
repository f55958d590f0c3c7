import fs from "node:fs";
import { describe, expect, it } from "vitest";

/** Red, green and blue, 0 to 255, and how much of it covers what is behind, 0 to 1. */
type Colour = readonly [number, number, number, number];

const read = (name: string) => fs.readFileSync(new URL(name, import.meta.url), "utf8");
const [, LIGHT = "", DARK = ""] = read("theme.css").split(":root {");
const PANELS = read("panels.css");

/** The name of the colour that surrounds what a selector of the panels means. */
function outline(selector: string): string {
  const [, rule = ""] = PANELS.split(`\n${selector} {`);
  const [, name] = /^[^}]*border: 1px solid var\(--([\w-]+)\)/.exec(rule) ?? [];
  if (name === undefined) {
    throw new Error(`${selector} has no outline`);
  }
  return name;
}

function colour(theme: string, name: string): Colour {
  const [, value = ""] = new RegExp(`--${name}: ([^;]+);`).exec(theme) ?? [];
  const hex = /^#(?:([\da-f])([\da-f])([\da-f])|([\da-f]{2})([\da-f]{2})([\da-f]{2}))$/.exec(value);
  if (hex) {
    const digits = hex.slice(1).filter((part) => part !== undefined);
    const [r = 0, g = 0, b = 0] = digits.map((part) => Number.parseInt(part.padStart(2, part), 16));
    return [r, g, b, 1];
  }
  const [r = 0, g = 0, b = 0, percent = 100] = (value.match(/\d+/g) ?? []).map(Number);
  return [r, g, b, percent / 100];
}

/** Relative luminance, as WCAG has it. */
function luminance([r, g, b]: Colour): number {
  const linear = (part: number) =>
    part <= 10.3 ? part / 255 / 12.92 : ((part / 255 + 0.055) / 1.055) ** 2.4;
  return 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
}

function contrast(one: Colour, other: Colour): number {
  const [a, b] = [luminance(one), luminance(other)];
  return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
}

/** A panel before a street that is as dark, or as bright, as can be. */
function inFrontOf(street: number, [r, g, b, cover]: Colour): Colour {
  const mix = (part: number) => part * cover + street * (1 - cover);
  return [mix(r), mix(g), mix(b), 1];
}

describe.each([
  ["light", LIGHT],
  ["dark", DARK],
])("in the %s theme", (_, theme) => {
  it.each(["text", "quiet", "accent"])("%s can be read whatever lies behind a panel", (ink) => {
    for (const street of [0, 255]) {
      const panel = inFrontOf(street, colour(theme, "panel"));
      expect(contrast(colour(theme, ink), panel)).toBeGreaterThanOrEqual(4.5);
    }
  });

  // A swatch may be as dark, or as bright, as the panel: its outline is seen on any.
  it.each([".key::before", ".legend .ramp"])("%s is seen whatever lies behind", (swatch) => {
    for (const street of [0, 255]) {
      const panel = inFrontOf(street, colour(theme, "panel"));
      expect(contrast(colour(theme, outline(swatch)), panel)).toBeGreaterThanOrEqual(3);
    }
  });

  it("what is chosen can be read", () => {
    const contrasts = contrast(colour(theme, "on-accent"), colour(theme, "accent"));
    expect(contrasts).toBeGreaterThanOrEqual(4.5);
  });
});
