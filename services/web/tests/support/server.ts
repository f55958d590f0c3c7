import { type ChildProcess, spawn } from "node:child_process";
import { once } from "node:events";
import { FLANEUR, STORE } from "./place";

/** How long a server may take to start or to end, milliseconds. */
const PATIENCE_MS = 30_000;

/** A served store, as `flaneur serve` does it. */
export class Server {
  readonly #process: ChildProcess;
  readonly url: string;

  private constructor(process: ChildProcess, url: string) {
    this.#process = process;
    this.url = url;
  }

  /** At a free port, or at one that a former server had; `more` are further arguments. */
  static async start(port = 0, store = STORE, more: readonly string[] = []): Promise<Server> {
    const listen = `127.0.0.1:${port}`;
    const started = spawn(FLANEUR, ["serve", store, "--listen", listen, ...more], {
      stdio: ["ignore", "pipe", "ignore"],
    });
    let said = "";
    const url = await new Promise<string>((resolve, reject) => {
      const timer = setTimeout(() => reject(new Error("the server says nothing")), PATIENCE_MS);
      started.stdout?.on("data", (data: Buffer) => {
        said += data.toString();
        const [, address] = /serving (http:\/\/\S+)/.exec(said) ?? [];
        if (address) {
          clearTimeout(timer);
          resolve(address);
        }
      });
      started.once("exit", (code) => reject(new Error(`the server ended with ${code}`)));
    });
    return new Server(started, url);
  }

  get port(): number {
    return Number(new URL(this.url).port);
  }

  get pid(): number {
    return this.#process.pid ?? 0;
  }

  /** Asks it to end. */
  stop(): void {
    this.#process.kill("SIGTERM");
  }

  /** Ends it as a crash does: at once, and without a word. */
  async kill(): Promise<void> {
    if (this.#process.exitCode === null && this.#process.signalCode === null) {
      const gone = once(this.#process, "exit");
      this.#process.kill("SIGKILL");
      await gone;
    }
  }
}
