import { once } from "node:events";
import net from "node:net";

/**
 * A link to a server that can be cut as a walk out of a network's reach cuts it: the page loses its
 * connections, and the server hears nothing of it.
 */
export class Link {
  readonly #gate: net.Server;
  readonly #near = new Set<net.Socket>();
  readonly #far = new Set<net.Socket>();
  #isCut = false;

  private constructor(port: number) {
    this.#gate = net.createServer((near) => {
      if (this.#isCut) {
        near.destroy();
        return;
      }
      const far = net.connect(port, "127.0.0.1");
      this.#near.add(near);
      this.#far.add(far);
      near.on("data", (data) => far.write(data));
      // Without a page, what comes is lost.
      far.on("data", (data) => near.destroyed || near.write(data));
      far.on("close", () => near.destroy());
      near.on("close", () => this.#isCut || far.destroy());
      for (const socket of [near, far]) {
        socket.on("error", () => socket.destroy());
      }
    });
  }

  /** To a port of this machine. */
  static async to(port: number): Promise<Link> {
    const link = new Link(port);
    await once(link.#gate.listen(0, "127.0.0.1"), "listening");
    return link;
  }

  get url(): string {
    const address = this.#gate.address();
    return `http://127.0.0.1:${typeof address === "object" ? address?.port : ""}`;
  }

  cut(): void {
    this.#isCut = true;
    for (const near of this.#near) {
      near.destroy();
    }
  }

  mend(): void {
    this.#isCut = false;
  }

  async close(): Promise<void> {
    const gone = once(this.#gate, "close");
    this.#gate.close();
    for (const socket of [...this.#near, ...this.#far]) {
      socket.destroy();
    }
    await gone;
  }
}
