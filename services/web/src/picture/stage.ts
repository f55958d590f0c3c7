import type { Frame } from "../gen/flaneur/v1/render_pb";
import { distance } from "../geometry/vector";
import { covers, cssTransform, homography } from "../view/homography";
import type { Pinhole } from "../view/pinhole";
import { type Pose, samePose } from "../view/pose";

/** Pictures that are kept at most. */
const MOST_PICTURES = 5;
/** From farther away a former picture is no help, metres. */
const REACH_M = 4;
/** How far ahead things are taken to be where a picture is shown from another eye, metres. */
const AHEAD_M = 12;

/** Size of the blurred picture behind all others. */
const BACKDROP = { width: 24, height: 14 };

interface Picture {
  readonly canvas: HTMLCanvasElement;
  readonly camera: Pinhole;
  readonly mode: number;
  /** As good as it can be. */
  readonly whole: boolean;
}

/**
 * The street as it is now: the newest frame, moved to where one looks by the homography between
 * its view and the present one, and beneath it a few older ones for where it does not reach.
 * Behind all lie its mere colours, so that nothing is ever blank.
 */
export class Stage {
  readonly #host: HTMLElement;
  /** The newest last. */
  #pictures: Picture[] = [];
  #spare: HTMLCanvasElement[] = [];
  readonly #backdrop = document.createElement("canvas");
  #shown: Pinhole;
  #onShown: () => void = () => {};

  constructor(host: HTMLElement, pose: Pose) {
    this.#host = host;
    this.#shown = { pose, width: host.clientWidth, height: host.clientHeight };
    this.#backdrop.className = "backdrop";
    this.#backdrop.width = BACKDROP.width;
    this.#backdrop.height = BACKDROP.height;
    host.append(this.#backdrop);
  }

  /** What is on the screen: its pose, and its size in CSS pixels. */
  get shown(): Pinhole {
    return this.#shown;
  }

  /** Calls the listener after each change of what is on the screen. */
  onShown(listener: () => void): void {
    this.#onShown = listener;
  }

  /** Puts a frame on top once it is decoded. Frames without a picture or a view are none. */
  async add(frame: Frame): Promise<void> {
    const camera = cameraOf(frame);
    if (!camera || frame.image.length === 0) {
      return;
    }
    const mode = frame.view?.mode ?? 0;
    const newest = this.#pictures.at(-1);
    if (!frame.final && newest?.whole && newest.mode === mode && sameView(newest.camera, camera)) {
      // A session that begins anew has less to show, at first, than what is shown.
      return;
    }
    const file = new Blob([frame.image as Uint8Array<ArrayBuffer>], { type: frame.mediaType });
    const bitmap = await createImageBitmap(file);
    const canvas = this.#spare.pop() ?? newCanvas();
    canvas.width = bitmap.width;
    canvas.height = bitmap.height;
    canvas.style.width = `${camera.width}px`;
    canvas.style.height = `${camera.height}px`;
    const { width, height } = BACKDROP;
    this.#backdrop.getContext("2d")?.drawImage(bitmap, 0, 0, width, height);
    // Takes the pixels over without a copy, before the canvas is seen.
    canvas.getContext("bitmaprenderer")?.transferFromImageBitmap(bitmap);
    this.#pictures = this.#pictures.filter((picture) => {
      const stays = picture.mode === mode && isOfUse(picture, camera);
      if (!stays) {
        this.#drop(picture);
      }
      return stays;
    });
    const whole = frame.final && frame.fault === "";
    this.#pictures.push({ canvas, camera, mode, whole });
    const oldest = this.#pictures.length > MOST_PICTURES ? this.#pictures.shift() : undefined;
    if (oldest) {
      this.#drop(oldest);
    }
    this.#host.append(canvas);
    this.show(this.#shown.pose);
  }

  /** Shows the street at a pose. */
  show(pose: Pose): void {
    const shown = { pose, width: this.#host.clientWidth, height: this.#host.clientHeight };
    this.#shown = shown;
    let covered = false;
    for (const picture of [...this.#pictures].reverse()) {
      const { style } = picture.canvas;
      if (covered) {
        style.visibility = "hidden";
        continue;
      }
      const h = homography(shown, picture.camera, AHEAD_M);
      style.transform = cssTransform(h);
      style.visibility = "visible";
      covered = covers(h, picture.camera, shown);
    }
    this.#onShown();
  }

  #drop(picture: Picture): void {
    picture.canvas.remove();
    if (this.#spare.length < MOST_PICTURES) {
      this.#spare.push(picture.canvas);
    }
  }
}

/** Whether two pictures show the same, of whatever size they are. */
function sameView(a: Pinhole, b: Pinhole): boolean {
  const shape = (a.width * b.height) / (a.height * b.width);
  return samePose(a.pose, b.pose) && Math.abs(shape - 1) < 0.01;
}

/** Whether an older picture shows what the newest does not. */
function isOfUse(picture: Picture, newest: Pinhole): boolean {
  if (distance(picture.camera.pose.eye, newest.pose.eye) > REACH_M) {
    return false;
  }
  return !covers(homography(picture.camera, newest, AHEAD_M), newest, picture.camera);
}

function cameraOf(frame: Frame): Pinhole | undefined {
  const { view } = frame;
  if (!view?.eye || view.extent.case !== "fovDeg" || view.width < 1 || view.height < 1) {
    return undefined;
  }
  const { x, y, z } = view.eye;
  const { headingDeg, pitchDeg, width, height } = view;
  return {
    pose: { eye: [x, y, z], headingDeg, pitchDeg, fovDeg: view.extent.value },
    width,
    height,
  };
}

function newCanvas(): HTMLCanvasElement {
  const canvas = document.createElement("canvas");
  canvas.className = "picture";
  canvas.ariaHidden = "true";
  return canvas;
}
