/** Place on the stage, CSS pixels from its top left corner. */
export type ScreenPoint = readonly [number, number];

/** What hands can do to a view. */
export interface Steering {
  /** Drags the street along by so many CSS pixels. */
  drag(dx: number, dy: number): void;
  /** Narrows (> 1) or widens (< 1) the view about a point. */
  zoom(factor: number, about: ScreenPoint): void;
  /** Clicks or taps once. */
  act(at: ScreenPoint): void;
  /** Clicks or taps the same place once more, at once. */
  actTwice(at: ScreenPoint): void;
}
