import { element } from "../dom";
import { icon } from "../icons";
import { isLayer, type Layer, MAIN_LAYERS, MORE_LAYERS } from "../state/layer";
import type { Value } from "../state/value";
import { TEXT } from "../strings";

/** Switches of what is shown: the usual ones at once, the others behind a button. */
export function layerSwitches(layer: Value<Layer>): HTMLElement {
  const more = element("div", { class: "more-layers", id: "more-layers", hidden: true });
  const button = element("button", {
    type: "button",
    class: "more-button",
    "aria-expanded": "false",
    "aria-controls": "more-layers",
    "aria-label": TEXT.moreLayers,
    title: TEXT.moreLayers,
  });
  const expand = (open: boolean) => {
    more.hidden = !open;
    button.setAttribute("aria-expanded", String(open));
  };
  button.addEventListener("click", (event) => {
    expand(more.hidden);
    if (!more.hidden && event.detail === 0) {
      // Whoever came by keys would pass by: of all that can be chosen Tab reaches what is chosen alone.
      (more.querySelector<HTMLInputElement>(":checked") ?? more.querySelector("input"))?.focus();
    }
  });
  const root = element(
    "fieldset",
    { class: "layers floating" },
    element("legend", { class: "unseen" }, TEXT.layers),
    ...MAIN_LAYERS.map((name) => option(name)),
    button,
    more,
  );
  more.append(...MORE_LAYERS.map((name) => option(name)));
  root.addEventListener("change", (event) => {
    if (event.target instanceof HTMLInputElement && isLayer(event.target.value)) {
      layer.set(event.target.value);
    }
  });
  root.addEventListener("click", (event) => {
    // Whoever goes through them by keys goes on.
    if (event.target instanceof HTMLInputElement && event.detail > 0) {
      expand(false);
    }
  });
  // Whoever goes on by keys is done with it; the street has the keys after each click.
  root.addEventListener("focusout", ({ relatedTarget: next }) => {
    if (next instanceof Element && !next.matches(".stage") && !root.contains(next)) {
      expand(false);
    }
  });
  // Wherever one is: after a click the street has the keys.
  document.addEventListener("keydown", (event) => {
    if (event.key === "Escape" && !more.hidden) {
      if (root.contains(document.activeElement)) {
        button.focus();
      }
      expand(false);
      event.stopPropagation();
    }
  });
  document.addEventListener("pointerdown", (event) => {
    if (event.target instanceof Node && !root.contains(event.target)) {
      expand(false);
    }
  });
  layer.watch((name) => {
    const input = root.querySelector<HTMLInputElement>(`input[value=${name}]`);
    if (input) {
      input.checked = true;
    }
    const isMore = MORE_LAYERS.includes(name);
    const chosen = TEXT.layerNames[name];
    button.classList.toggle("chosen", isMore);
    button.ariaLabel = isMore ? `${TEXT.moreLayers}: ${chosen}` : TEXT.moreLayers;
    button.replaceChildren(...(isMore ? [element("span", {}, chosen)] : []), icon("more"));
  });
  return root;
}

function option(name: Layer): HTMLElement {
  const input = element("input", { type: "radio", name: "layer", value: name });
  const label = element("span", {}, TEXT.layerNames[name]);
  return element("label", { title: TEXT.layerHelp[name] }, input, label);
}

/** What a layer shows, for those that do not look like a street. */
export function layerLegend(layer: Value<Layer>): HTMLElement {
  const root = element("div", { class: "legend floating", role: "note" });
  layer.watch((name) => {
    root.hidden = ["hybrid", "mesh", "points"].includes(name);
    const title = element("strong", {}, TEXT.layerNames[name]);
    if (name !== "uncertainty") {
      root.replaceChildren(title, element("p", {}, TEXT.layerHelp[name]));
      return;
    }
    const { centimetre, decimetre, metre, unseen, inferred } = TEXT.legend;
    root.replaceChildren(
      title,
      element("p", {}, TEXT.layerHelp.uncertainty),
      element("div", { class: "ramp", "aria-hidden": "true" }),
      element(
        "div",
        { class: "ticks" },
        ...[centimetre, decimetre, metre].map((text) => element("span", {}, text)),
      ),
      element(
        "div",
        { class: "keys" },
        element("span", { class: "key dark" }, unseen),
        element("span", { class: "key magenta" }, inferred),
      ),
    );
  });
  return root;
}
