import { connect } from "./api/clients";
import { reasonOf } from "./api/failure";
import { element } from "./dom";
import { sceneList } from "./panels/scenes";
import { readLink } from "./state/url";
import { openStreet } from "./street";
import { TEXT } from "./strings";
import "./styles/page.css";
import { waitMs } from "./api/backoff";

const clients = connect(location.origin);
const page = document.querySelector<HTMLElement>("#page") ?? document.body;
void begin();

async function begin(): Promise<void> {
  const scenes = await patiently(async () => (await clients.scenes.listScenes({})).scenes);
  const link = readLink(location.search);
  const [only] = scenes;
  const scene =
    scenes.find(({ name }) => name === link.scene) ??
    (scenes.length === 1 && link.scene === undefined ? only : undefined);
  if (!scene) {
    page.replaceChildren(sceneList(scenes, link.scene));
    return;
  }
  await patiently(() => openStreet(page, clients, scenes, scene, link));
}

/** Tries until it succeeds, and says what is wrong meanwhile. */
async function patiently<T>(attempt: () => Promise<T>): Promise<T> {
  for (let failures = 1; ; failures += 1) {
    try {
      return await attempt();
    } catch (error) {
      const reason = reasonOf(error);
      const text = element("p", { class: "opening", role: "alert" }, TEXT.failed(reason));
      page.replaceChildren(text);
      await new Promise((resolve) => setTimeout(resolve, waitMs(failures, Math.random())));
    }
  }
}
