import type { Session } from "./api/session";
import type { Keys } from "./controls/keys";
import type { ScreenPoint, Steering } from "./controls/steering";
import { clamp, degrees, shortTurn } from "./geometry/angles";
import { planDistance, type Vector3 } from "./geometry/vector";
import type { Terrain } from "./ground/terrain";
import { type Flight, flight, poseAt } from "./motion/flight";
import type { Walls } from "./motion/slide";
import { walked } from "./motion/walk";
import type { Pace } from "./picture/pace";
import { pictureOf, type Screen, WHOLE } from "./picture/request";
import type { Stage } from "./picture/stage";
import type { Layer } from "./state/layer";
import { atRest } from "./state/url";
import type { Value } from "./state/value";
import { viewMessage } from "./view/message";
import { focalLength, type Pinhole, rayOf } from "./view/pinhole";
import { direction, normalised, type Pose, samePose } from "./view/pose";

/** One that has not moved for so long stands still, milliseconds, and gets the whole picture. */
const SETTLED_MS = 70;
/** A tab that was asleep does not leap, seconds. */
const LONGEST_STEP_S = 0.1;
/** The first step is made at once, as long as a frame of the screen takes, seconds. */
const FIRST_STEP_S = 1 / 60;

/** Pictures are asked for no farther ahead of a turning head, degrees ... */
const FARTHEST_LEAD_DEG = 25;
/** ... and the head's speed is that of the last moments, milliseconds. */
const LEAD_MEMORY_MS = 80;

/** What a person's hands and feet act on, and what asks for pictures accordingly. */
export interface VisitParts {
  readonly pose: Value<Pose>;
  readonly layer: Value<Layer>;
  readonly stage: Stage;
  readonly session: Session;
  readonly terrain: Terrain;
  readonly buildings: Walls;
  readonly pace: Pace;
  readonly keys: () => Keys;
  /** Clicks and taps, which mean several things. */
  readonly act: (at: ScreenPoint) => void;
  readonly actTwice: (at: ScreenPoint) => void;
  readonly screen: () => Screen;
  readonly still: () => boolean;
}

/** A walk through the street. Frames of the screen are drawn only while something moves. */
export class Visit implements Steering {
  readonly #parts: VisitParts;
  #flight: Flight | undefined;
  #ticking = false;
  #lastTickMs: number | undefined;
  /** Degrees a millisecond, clockwise. */
  #turning = 0;
  #turnedMs = 0;
  #asked: { camera: Pinhole; layer: Layer } | undefined;
  #settle: ReturnType<typeof setTimeout> | undefined;

  constructor(parts: VisitParts) {
    this.#parts = parts;
    parts.pose.watch(() => this.wake());
    parts.layer.watch(() => this.wake());
  }

  drag(dx: number, dy: number): void {
    this.#flight = undefined;
    const pose = this.#parts.pose.get();
    const focal = focalLength(this.#parts.stage.shown);
    this.#parts.pose.set(
      normalised({
        ...pose,
        headingDeg: pose.headingDeg - degrees(Math.atan(dx / focal)),
        pitchDeg: pose.pitchDeg + degrees(Math.atan(dy / focal)),
      }),
    );
  }

  zoom(factor: number, about: ScreenPoint): void {
    this.#flight = undefined;
    const pose = this.#parts.pose.get();
    const { width, height } = this.#parts.screen();
    const zoomed = normalised({ ...pose, fovDeg: pose.fovDeg / factor });
    // What is under the hand stays there.
    const was = direction(rayOf({ pose, width, height }, about));
    const is = direction(rayOf({ pose: zoomed, width, height }, about));
    this.#parts.pose.set(
      normalised({
        ...zoomed,
        headingDeg: zoomed.headingDeg + was.headingDeg - is.headingDeg,
        pitchDeg: zoomed.pitchDeg + was.pitchDeg - is.pitchDeg,
      }),
    );
  }

  act(at: ScreenPoint): void {
    this.#parts.act(at);
  }

  actTwice(at: ScreenPoint): void {
    this.#parts.actTwice(at);
  }

  /** Goes to a pose, eased; the pictures of its end are asked for at once. */
  go(to: Pose): void {
    this.#flight = flight(this.#parts.pose.get(), to, performance.now(), this.#parts.still());
    this.wake();
  }

  /** Goes to a place in plan, at the height above the ground that one has. */
  async goTo(x: number, y: number, eyeHeight: number): Promise<void> {
    const { terrain, pose } = this.#parts;
    await terrain.around(x, y);
    const now = pose.get();
    const ground = terrain.height(x, y);
    const eye: Vector3 = [x, y, ground === undefined ? now.eye[2] : ground + eyeHeight];
    this.go({ ...now, eye });
  }

  /** Something moves, or is to be asked for. */
  wake(): void {
    if (!this.#ticking) {
      this.#ticking = true;
      requestAnimationFrame((nowMs) => this.#tick(nowMs));
    }
  }

  /** Asks for the view once more, as after a change of the window. */
  again(): void {
    this.#asked = undefined;
    this.wake();
  }

  #tick(nowMs: number): void {
    this.#ticking = false;
    const { pose, stage, keys, terrain, buildings } = this.#parts;
    const before = stage.shown.pose;
    const gait = keys().step(nowMs);
    if (gait) {
      this.#flight = undefined;
      const seconds =
        this.#lastTickMs === undefined ? FIRST_STEP_S : (nowMs - this.#lastTickMs) / 1000;
      const height = (x: number, y: number) => terrain.height(x, y);
      pose.set(walked(pose.get(), gait, Math.min(seconds, LONGEST_STEP_S), height, buildings));
    } else if (this.#flight) {
      const next = poseAt(this.#flight, performance.now());
      pose.set(next.pose);
      this.#flight = next.done ? undefined : this.#flight;
    }
    this.#lastTickMs = gait ? nowMs : undefined;
    const now = pose.get();
    stage.show(now);
    if (planDistance(before.eye, now.eye) > 0) {
      void terrain.around(now.eye[0], now.eye[1]);
    }
    this.#noteTurn(shortTurn(before.headingDeg, now.headingDeg), nowMs);
    this.#ask(this.#flight?.to ?? now, this.#flight !== undefined || !samePose(before, now));
    if (gait || this.#flight) {
      this.wake();
    }
  }

  /** Stands exactly where a link to the view leads, so that both show the same picture. */
  #rest(): void {
    const { pose, stage } = this.#parts;
    const now = pose.get();
    const rest = atRest(now);
    if (!this.#flight && !samePose(now, rest)) {
      stage.show(rest);
      pose.set(rest);
    }
  }

  #noteTurn(turnDeg: number, nowMs: number): void {
    const passed = Math.min(Math.max(nowMs - this.#turnedMs, 4), LEAD_MEMORY_MS);
    const part = passed / LEAD_MEMORY_MS;
    this.#turning += part * (turnDeg / passed - this.#turning);
    this.#turnedMs = nowMs;
  }

  /** Where the head will be by when a picture is there. */
  #ahead(pose: Pose): Pose {
    const lead = this.#turning * this.#parts.pace.delayMs;
    const headingDeg = pose.headingDeg + clamp(lead, -FARTHEST_LEAD_DEG, FARTHEST_LEAD_DEG);
    return normalised({ ...pose, headingDeg });
  }

  /** Asks for pictures of a pose: quick ones on the way, the whole one at rest. */
  #ask(pose: Pose, moving: boolean): void {
    const { session, pace, screen } = this.#parts;
    const layer = this.#parts.layer.get();
    if (moving || this.#settle !== undefined) {
      clearTimeout(this.#settle);
      this.#settle = setTimeout(() => {
        this.#settle = undefined;
        this.#rest();
        this.wake();
      }, SETTLED_MS);
    }
    const asked = this.#asked;
    const turns = asked !== undefined && asked.camera.pose.headingDeg !== pose.headingDeg;
    const camera =
      this.#settle === undefined
        ? pictureOf(pose, screen(), WHOLE)
        : pictureOf(this.#flight ? pose : this.#ahead(pose), screen(), pace.moving(turns));
    if (!asked || asked.layer !== layer || !sameCamera(asked.camera, camera)) {
      this.#asked = { camera, layer };
      session.want(viewMessage(camera, layer));
    }
  }
}

function sameCamera(a: Pinhole, b: Pinhole): boolean {
  return a.width === b.width && a.height === b.height && samePose(a.pose, b.pose);
}
