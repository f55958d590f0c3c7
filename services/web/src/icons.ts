import { svg } from "./dom";

/** Strokes in a square of 24. */
const PATHS = {
  measure: "M3.5 15.5 15.5 3.5l5 5-12 12zM7 12l2 2m1-5 2 2m1-5 2 2",
  map: "M9 4 3.5 6.2V20L9 17.8l6 2.2 5.5-2.2V4L15 6.2zm0 0v13.8M15 6.2V20",
  link: "M10 14a4 4 0 0 0 5.7 0l3.1-3.1a4 4 0 0 0-5.7-5.7L12 6.3M14 10a4 4 0 0 0-5.7 0l-3.1 3.1a4 4 0 0 0 5.7 5.7l1.1-1.1",
  help: "M9.2 9.3a2.9 2.9 0 1 1 4.3 2.6c-1 .5-1.5 1-1.5 2.2M12 17.2v.1",
  copy: "M9 9h10v11H9zM5 15V4h10",
  done: "M5 12.5 10 17.5 19.5 7",
  close: "M6 6l12 12M18 6 6 18",
  open: "M6 15l6-6 6 6",
  plus: "M12 5v14M5 12h14",
  minus: "M5 12h14",
  more: "M5.4 12a.6.6 0 1 0 1.2 0 .6.6 0 1 0-1.2 0m6 0a.6.6 0 1 0 1.2 0 .6.6 0 1 0-1.2 0m6 0a.6.6 0 1 0 1.2 0 .6.6 0 1 0-1.2 0",
} as const;

export type Icon = keyof typeof PATHS;

/** An icon as large as its text; it says nothing to those who listen. */
export function icon(name: Icon): SVGSVGElement {
  const shape = svg("path", { d: PATHS[name] });
  return svg("svg", { class: "icon", viewBox: "0 0 24 24", "aria-hidden": "true" }, shape);
}
