import { element } from "../dom";
import type { Frame } from "../gen/flaneur/v1/render_pb";
import type { Scene } from "../gen/flaneur/v1/scene_pb";
import { isWithin } from "../state/start";
import { TEXT } from "../strings";

/** Less of a picture is next to nothing. */
const NEXT_TO_NOTHING = 0.001;

/** So far outside of a scene the sky alone is no view of it, metres. */
const OUTSIDE_M = 100;

/** Says that nothing of the scene is in sight, and leads back. */
export class Astray {
  readonly root: HTMLElement;
  readonly #scene: Pick<Scene, "bounds">;
  readonly #words = element("p", { role: "status" });

  constructor(scene: Pick<Scene, "bounds">, back: () => void) {
    this.#scene = scene;
    const button = element("button", { type: "button", class: "main" }, TEXT.backToStreet);
    button.addEventListener("click", back);
    this.root = element("div", { class: "astray floating", hidden: true }, this.#words, button);
  }

  frame(frame: Frame): void {
    const isShown = isAstray(frame, this.#scene);
    // What is still loading may come into sight; what is there already has.
    if (frame.final || !isShown) {
      this.root.hidden = !isShown;
      this.#words.textContent = isShown ? TEXT.nothingInSight : "";
    }
  }
}

/**
 * Whether a picture shows next to nothing of a scene; who stands in a street may look at the sky, even at one that no
 * photograph shows. The window has the same rule, and both are tested with astray.cases.json.
 */
export function isAstray(
  frame: Pick<Frame, "view" | "unsurveyedShare" | "blankShare">,
  scene: Pick<Scene, "bounds">,
): boolean {
  if (frame.unsurveyedShare <= 1 - NEXT_TO_NOTHING) {
    return false;
  }
  const { x = 0, y = 0, z = 0 } = frame.view?.eye ?? {};
  const isBlank = frame.blankShare > 1 - NEXT_TO_NOTHING;
  return !isWithin(scene, [x, y, z], OUTSIDE_M) || (isBlank && !isOfSky(frame.view));
}

/** Whether all of a picture lies above the horizon. */
function isOfSky(view: Frame["view"]): boolean {
  return view?.extent.case === "fovDeg" && view.pitchDeg > view.extent.value / 2;
}
