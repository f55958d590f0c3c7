import type { Clients } from "../api/clients";
import { reasonOf } from "../api/failure";
import { element } from "../dom";
import type { Place, Sight } from "../gen/flaneur/v1/render_pb";
import type { Vector3 } from "../geometry/vector";
import { icon } from "../icons";
import { roughMetres } from "../measure/measurement";
import { dateOf } from "../measure/panel";
import { positionOf } from "../place/pick";
import { TEXT } from "../strings";
import { type Catalogue, placeOf } from "./catalogue";
import { fetchPhotograph, levelFor } from "./file";
import { quarterTurns } from "./upright";

/** Panoramas are looked for so much farther than a sight says, metres: a camera is not its rig. */
const SLACK_M = 10;

/** Shows a photograph as it was taken, with a mark where the place is. */
export class PhotographDialog {
  readonly root: HTMLDialogElement;
  readonly #client: Clients["panoramas"];
  readonly #scene: string;
  readonly #catalogue: Catalogue;
  readonly #title = element("h2");
  readonly #facts = element("p", { class: "aside" });
  readonly #frame = element("div", { class: "photograph" });
  readonly #stand = element("button", { type: "button", class: "text" }, TEXT.standThere);
  #loading: AbortController | undefined;
  #url: string | undefined;
  /** Where the photograph was taken, and the place that it shows. */
  #taken: { readonly from: Vector3; readonly place: Place } | undefined;

  constructor(
    client: Clients["panoramas"],
    scene: string,
    catalogue: Catalogue,
    stand: (eye: Vector3, place: Place) => void,
  ) {
    this.#client = client;
    this.#scene = scene;
    this.#catalogue = catalogue;
    const close = element("button", { type: "button", class: "plain", "aria-label": TEXT.close });
    close.append(icon("close"));
    close.addEventListener("click", () => this.root.close());
    this.root = element(
      "dialog",
      { class: "photograph-dialog", "aria-labelledby": "photograph-title" },
      element("header", {}, this.#title, close),
      this.#frame,
      element("footer", {}, this.#facts, this.#stand),
    );
    this.#title.id = "photograph-title";
    this.root.addEventListener("close", () => this.#forget());
    // A click beside the dialog closes it.
    this.root.addEventListener("click", (event) => {
      if (event.target === this.root) {
        this.root.close();
      }
    });
    this.#stand.addEventListener("click", () => {
      const taken = this.#taken;
      this.root.close();
      if (taken) {
        stand(taken.from, taken.place);
      }
    });
  }

  async open(sight: Sight, place: Place): Promise<void> {
    this.#forget();
    const loading = new AbortController();
    this.#loading = loading;
    this.#title.textContent = TEXT.photograph(sight.panorama, sight.camera);
    this.#facts.textContent = `${dateOf(sight.time)} · ${TEXT.away(roughMetres(sight.distanceM))}`;
    this.#stand.hidden = true;
    this.#frame.replaceChildren(element("p", { role: "status" }, TEXT.photographLoading));
    this.root.showModal();
    try {
      const shown = await this.#load(sight, place, loading.signal);
      if (!loading.signal.aborted) {
        this.#frame.replaceChildren(shown);
        this.#stand.hidden = false;
      }
    } catch (error) {
      if (!loading.signal.aborted) {
        const reason = reasonOf(error);
        const text = TEXT.photographFailed(reason);
        this.#frame.replaceChildren(element("p", { role: "alert" }, text));
      }
    }
  }

  async #load(sight: Sight, place: Place, signal: AbortSignal): Promise<HTMLElement> {
    const reach = sight.distanceM + SLACK_M;
    const panorama = await this.#catalogue.find(sight.panorama, positionOf(place), reach);
    const camera = panorama?.cameras.find(({ id }) => id === sight.camera);
    if (!panorama || !camera) {
      throw new Error(TEXT.photographMissing);
    }
    this.#taken = { from: placeOf(panorama, camera), place };
    const key = {
      scene: this.#scene,
      panorama: panorama.id,
      camera: camera.id,
      level: levelFor(camera),
    };
    const file = await fetchPhotograph(this.#client, key, signal);
    const url = URL.createObjectURL(file);
    const image = element("img", { src: url, alt: TEXT.photograph(panorama.id, camera.id) });
    this.#url = url;
    await image.decode();
    return turned(image, quarterTurns(panorama, camera), [
      (sight.pixel?.x ?? 0) / camera.width,
      (sight.pixel?.y ?? 0) / camera.height,
    ]);
  }

  #forget(): void {
    this.#loading?.abort();
    this.#loading = undefined;
    this.#taken = undefined;
    this.#frame.replaceChildren();
    if (this.#url) {
      URL.revokeObjectURL(this.#url);
      this.#url = undefined;
    }
  }
}

/** The photograph upright, as large as its box, with a mark at a place given in parts of its size. */
function turned(
  image: HTMLImageElement,
  turns: number,
  [u, v]: readonly [number, number],
): HTMLElement {
  const sideways = turns % 2 === 1;
  const [width, height] = [image.naturalWidth, image.naturalHeight];
  const box = element("div", { class: "upright" });
  const ratio = sideways ? height / width : width / height;
  box.style.setProperty("--ratio", String(ratio));
  image.style.transform = `translate(-50%, -50%) rotate(${turns * 90}deg)`;
  image.style.width = sideways ? `${100 / ratio}%` : "100%";
  // Turned with the picture, clockwise.
  const places: [number, number][] = [
    [u, v],
    [1 - v, u],
    [1 - u, 1 - v],
    [v, 1 - u],
  ];
  const [x, y] = places[turns] ?? [u, v];
  const mark = element("span", { class: "mark", "aria-hidden": "true" });
  mark.style.left = `${x * 100}%`;
  mark.style.top = `${y * 100}%`;
  box.append(image, mark);
  return box;
}
