import { webcrypto } from "node:crypto";
import { describe, expect, it, vi } from "vitest";
import { waitMs } from "./backoff";
import { randomToken } from "./token";

// Node.js 18 has it, but not where browsers have it.
vi.stubGlobal("crypto", webcrypto);

describe("trying again", () => {
  it("waits twice as long each time, up to ten seconds, and never all at once", () => {
    expect([1, 2, 3].map((failures) => waitMs(failures, 1))).toEqual([400, 800, 1600]);
    expect(waitMs(50, 1)).toBe(10_000);
    expect(waitMs(5000, 0)).toBe(5000);
    expect(waitMs(3, 0)).toBe(800);
  });
});

describe("a session's name", () => {
  it("is one that the server takes, and never the same", () => {
    const names = Array.from({ length: 200 }, randomToken);
    for (const name of names) {
      expect(name).toMatch(/^[A-Za-z0-9_-]{16,64}$/);
    }
    expect(new Set(names).size).toBe(names.length);
  });
});
