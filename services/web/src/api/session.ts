import { create, type MessageInitShape } from "@bufbuild/protobuf";
import { Code, ConnectError } from "@connectrpc/connect";
import {
  type Frame,
  type UpdateViewRequestSchema,
  type View,
  ViewSchema,
} from "../gen/flaneur/v1/render_pb";
import { waitMs } from "./backoff";
import type { Clients } from "./clients";
import { answered, type FailureKind, failureOf, retryDelayMs } from "./failure";
import { randomToken } from "./token";

/** How a session stands. */
export type SessionState =
  | { readonly kind: "connecting" }
  | { readonly kind: "live" }
  /** The server ended it after a long rest; the next view begins another. */
  | { readonly kind: "resting" }
  /**
   * Tried again at `retryAtMs`, as `performance.now()` has it. The reason is what the server said;
   * one that is lost may have said nothing.
   */
  | { readonly kind: FailureKind; readonly reason: string; readonly retryAtMs: number }
  /** As asked, it cannot be had: trying again is of no use. */
  | { readonly kind: "refused"; readonly reason: string };

export interface SessionListener {
  /** Shows a frame; resolves once it is decoded. */
  frame(frame: Frame): Promise<void>;
  state(state: SessionState): void;
  /** A view was asked for; frames that show it will echo its number. */
  wanted(sequence: bigint): void;
}

/** No answer for so long is no connection. */
const ANSWER_MS = 8000;

/** Where the server says that views come too fast, and not when the next may come: after so long. */
const SLOWER_MS = 200;

/** A view that is refused is not followed by another one sooner, milliseconds. */
const REFUSED_MS = 1000;

/** Codes that another attempt would only meet again. */
const HOPELESS = new Set([
  Code.InvalidArgument,
  Code.NotFound,
  Code.OutOfRange,
  Code.PermissionDenied,
  Code.Unauthenticated,
  Code.Unimplemented,
]);

/**
 * Views go out, frames come in. Only the newest view is ever sent, and one call is under way at a
 * time: browsers have few connections to a server, and other pages may want some. Where the
 * connection is lost, a new session with the newest view begins once the server is back.
 */
export class Session {
  readonly #render: Clients["render"];
  readonly #scene: string;
  readonly #listener: SessionListener;
  /**
   * Its name. Watched again by it a session keeps its place, also where the server has not noticed yet
   * that the connection was lost.
   */
  #token = randomToken();
  #view: View | undefined;
  #sequence = 0n;
  /** Of the views, the newest that the server was sent. */
  #sent = 0n;
  #received = 0n;
  #acknowledged = 0n;
  #sending = false;
  /** Whether the server knows the session. */
  #open = false;
  #watching: AbortController | undefined;
  #failures = 0;
  /** After a refusal the next attempt waits until then, as `performance.now()` has it. */
  #notBeforeMs = 0;
  #retry: ReturnType<typeof setTimeout> | undefined;
  #closed = false;

  constructor(render: Clients["render"], scene: string, listener: SessionListener) {
    this.#render = render;
    this.#scene = scene;
    this.#listener = listener;
  }

  /**
   * Metadata that leads a call to the server which has the session, and so the scene: proxies do
   * not read messages.
   */
  get headers(): Record<string, string> {
    return { "flaneur-session": this.#token };
  }

  /** Asks for frames of a view; those of former views are of no more use. */
  want(view: View): void {
    this.#view = view;
    this.#sequence += 1n;
    this.#listener.wanted(this.#sequence);
    if (this.#closed) {
      return;
    }
    if (this.#watching) {
      this.#pump();
    } else if (this.#retry === undefined) {
      this.#watchAfter(this.#notBeforeMs - performance.now());
    }
  }

  /** Tries again at once where it waits to. */
  hurry(): void {
    if (this.#retry !== undefined) {
      clearTimeout(this.#retry);
      this.#retry = undefined;
      void this.#watch();
    }
  }

  close(): void {
    this.#closed = true;
    clearTimeout(this.#retry);
    this.#retry = undefined;
    this.#watching?.abort();
  }

  async #watch(): Promise<void> {
    const view = this.#view;
    if (!view || this.#closed) {
      return;
    }
    const watching = new AbortController();
    this.#watching = watching;
    this.#sent = this.#sequence;
    this.#received = 0n;
    this.#acknowledged = 0n;
    this.#open = false;
    this.#listener.state({ kind: "connecting" });
    try {
      const frames = this.#render.watch(
        {
          session: this.#token,
          update: { scene: this.#scene, sequence: this.#sequence, view },
        },
        {
          signal: watching.signal,
          headers: this.headers,
          timeoutMs: 0,
          onHeader: () => {
            if (this.#watching === watching) {
              this.#open = true;
              // Views that came while it connected.
              this.#pump();
            }
          },
        },
      );
      for await (const frame of frames) {
        if (this.#watching !== watching) {
          return;
        }
        if (this.#received === 0n) {
          this.#failures = 0;
          this.#listener.state({ kind: "live" });
        }
        await this.#listener.frame(frame);
        this.#received = frame.number;
        this.#pump();
      }
      this.#ended(watching, new ConnectError("", Code.Unavailable));
    } catch (error) {
      this.#ended(watching, ConnectError.from(error));
    }
  }

  /** Sends what is new: the newest view, the last frame received, or both. */
  #pump(): void {
    const watching = this.#watching;
    const newView = this.#sent < this.#sequence;
    if (
      this.#sending ||
      !watching ||
      !this.#open ||
      !(newView || this.#acknowledged < this.#received)
    ) {
      return;
    }
    const request: MessageInitShape<typeof UpdateViewRequestSchema> = {
      session: this.#token,
      update: {
        sequence: this.#sequence,
        receivedFrame: this.#received,
        ...(newView && this.#view ? { view: create(ViewSchema, this.#view) } : {}),
      },
    };
    this.#sent = this.#sequence;
    this.#acknowledged = this.#received;
    this.#sending = true;
    this.#render
      .updateView(request, {
        signal: watching.signal,
        headers: this.headers,
        timeoutMs: ANSWER_MS,
      })
      .then(
        () => {
          this.#sending = false;
          this.#pump();
        },
        (error: unknown) => {
          this.#sending = false;
          this.#failed(watching, ConnectError.from(error));
        },
      );
  }

  /** An update came to nothing. */
  #failed(watching: AbortController, error: ConnectError): void {
    if (this.#watching !== watching) {
      this.#pump();
      return;
    }
    if (error.code === Code.NotFound) {
      if (this.#received === 0n) {
        // A session that was never there: its server and that of its views are not the same.
        this.#ended(watching, new ConnectError("", Code.Unavailable, error.metadata));
        return;
      }
      // The session is gone; nothing was lost but that.
      this.#forget();
      void this.#watch();
      return;
    }
    if (error.code === Code.ResourceExhausted) {
      // Too many views; the newest goes a little later.
      this.#sent = 0n;
      setTimeout(() => this.#pump(), retryDelayMs(error) ?? SLOWER_MS);
      return;
    }
    // What is not answered in time is lost; only a stream that ends so has rested too long.
    const late = error.code === Code.DeadlineExceeded;
    this.#ended(watching, late ? new ConnectError("", Code.Unavailable) : error);
  }

  #ended(watching: AbortController, error: ConnectError): void {
    if (this.#watching !== watching || this.#closed) {
      return;
    }
    this.#forget();
    if (answered(error)) {
      // There it is no more. Another name may lead to another server.
      this.#token = randomToken();
    }
    if (error.code === Code.DeadlineExceeded && this.#failures === 0 && this.#received > 0n) {
      this.#listener.state({ kind: "resting" });
    } else if (HOPELESS.has(error.code)) {
      this.#notBeforeMs = performance.now() + REFUSED_MS;
      this.#listener.state({ kind: "refused", reason: error.rawMessage });
    } else {
      this.#failures += 1;
      const wait = waitMs(this.#failures, Math.random(), retryDelayMs(error));
      this.#watchAfter(wait);
      const retryAtMs = performance.now() + wait;
      // What the browser says of a failed connection says nothing.
      const told = answered(error) || error.code === Code.Unavailable;
      const reason = told ? error.rawMessage : "";
      this.#listener.state({ kind: failureOf(error), reason, retryAtMs });
    }
  }

  #watchAfter(waitMs: number): void {
    this.#retry = setTimeout(() => {
      this.#retry = undefined;
      void this.#watch();
    }, waitMs);
  }

  #forget(): void {
    const watching = this.#watching;
    this.#watching = undefined;
    watching?.abort();
  }
}
