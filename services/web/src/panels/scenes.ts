import { element } from "../dom";
import type { Scene } from "../gen/flaneur/v1/scene_pb";
import { TEXT } from "../strings";

/** The name of the scene, or a list of all to choose from. */
export function sceneSwitch(scenes: readonly Scene[], chosen: string): HTMLElement {
  if (scenes.length < 2) {
    return element("div", { class: "scene floating" }, chosen);
  }
  const options = scenes.map(({ name }) =>
    element("option", { value: name, selected: name === chosen }, name),
  );
  const select = element("select", { "aria-label": TEXT.chooseScene }, ...options);
  select.addEventListener("change", () => location.assign(sceneLink(select.value)));
  return element("div", { class: "scene floating" }, select);
}

/** A page of all scenes, where none was asked for. */
export function sceneList(scenes: readonly Scene[], unknown: string | undefined): HTMLElement {
  const items = scenes.map((scene) => {
    const points = scene.pointSources.reduce((sum, source) => sum + source.pointCount, 0n);
    const summary = TEXT.sceneSummary(scene.imageCount, scene.footprintCount, points);
    const link = element(
      "a",
      { href: sceneLink(scene.name) },
      element("strong", {}, scene.name),
      element("span", { class: "aside" }, summary),
    );
    return element("li", {}, link);
  });
  return element(
    "div",
    { class: "scene-list" },
    element("h1", {}, TEXT.scenes),
    ...(unknown === undefined ? [] : [element("p", {}, TEXT.unknownScene(unknown))]),
    element("p", {}, scenes.length > 0 ? TEXT.scenesIntro : TEXT.noScene),
    element("ul", {}, ...items),
  );
}

function sceneLink(name: string): string {
  return `?scene=${encodeURIComponent(name)}`;
}
