import { describe, expect, it } from "vitest";
import { type Quality, textAfter } from "./spoken";

/** What is said in the course of a visit. */
function said(...course: Quality[]): string[] {
  const texts: string[] = [];
  let before: Quality | undefined;
  for (const quality of course) {
    const text = textAfter(before, quality, quality === "full" ? "64 sessions" : "");
    if (text !== undefined) {
      texts.push(text);
      before = quality;
    }
  }
  return texts;
}

describe("what is read aloud of the status", () => {
  it("is that there is a picture, and no step towards a better one", () => {
    expect(said("connecting", "loading", "refining", "final")).toEqual(["Loading", "Final"]);
    expect(said("final", "refining", "final", "refining", "final")).toEqual(["Final"]);
  });

  it("is once that the connection is gone, and that it is back", () => {
    expect(said("final", "lost", "connecting", "lost", "connecting", "refining", "final")).toEqual([
      "Final",
      "No connection",
      "Connected again. Refining",
      "Final",
    ]);
  });

  it("has the reason, where there is one", () => {
    expect(said("full", "final")).toEqual(["Server full: 64 sessions", "Connected again. Final"]);
  });
});
