import { webcrypto } from "node:crypto";
import { Code, ConnectError } from "@connectrpc/connect";
import { describe, expect, it, vi } from "vitest";
import { waitMs } from "./backoff";
import { failureOf, reasonOf, retryDelayMs } from "./failure";
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

  it("waits no less than the server says", () => {
    expect(waitMs(1, 0, 2000)).toBe(2000);
    expect(waitMs(1, 1, 2000)).toBe(3000);
    expect(waitMs(6, 0, 2000)).toBe(5000);
  });
});

describe("a call that failed", () => {
  const said = { "grpc-status": "8" };
  const full = new ConnectError("the server is full", Code.ResourceExhausted, said);
  // retry_delay of 2.5 s, after a field that nobody knows.
  const value = Uint8Array.of(0x18, 7, 0x0a, 8, 0x08, 2, 0x10, 0x80, 0xca, 0xb5, 0xee, 1);
  full.details = [{ type: "google.rpc.RetryInfo", value }];

  it("says whether the server is full, has trouble, or was not heard of", () => {
    expect(failureOf(full)).toBe("full");
    expect(failureOf(new ConnectError("no driver", Code.Unavailable, said))).toBe("trouble");
    expect(failureOf(new ConnectError("HTTP 502", Code.Unavailable))).toBe("lost");
    expect(failureOf(ConnectError.from(new TypeError("Failed to fetch")))).toBe("lost");
  });

  it("says when to try again, where the server does", () => {
    expect(retryDelayMs(full)).toBe(2500);
    full.details = [{ type: "google.rpc.RetryInfo", value: value.subarray(0, 6) }];
    expect(retryDelayMs(full)).toBeUndefined();
    full.details = [];
    expect(retryDelayMs(full)).toBeUndefined();
  });

  it("is told in the server's words, and in the page's where it has none", () => {
    expect(reasonOf(full)).toBe("the server is full");
    const unheard = ConnectError.from(new TypeError("Failed to fetch"));
    expect(reasonOf(unheard)).toBe("there is no connection to the server");
    expect(reasonOf(new Error("the file has 3 bytes, 2 came"))).toContain("2 came");
    expect(reasonOf(new ConnectError("late", Code.DeadlineExceeded))).toContain("in time");
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
