import { type ChildProcess, spawn } from "node:child_process";
import { once } from "node:events";
import fs from "node:fs";
import net from "node:net";
import os from "node:os";
import path from "node:path";
import { ROOT, STORE } from "./place";
import { Server } from "./server";

/** How long nginx may take to listen, milliseconds. */
const PATIENCE_MS = 20_000;

/** What `deploy/compose.yaml` starts, as plain processes: data, two render replicas, nginx before them. */
export class Gateway {
  readonly #data: Server;
  readonly #nginx: ChildProcess;
  readonly #folder: string;
  readonly replicas: readonly Server[];
  /** Of the page. */
  readonly url: string;

  private constructor(
    data: Server,
    replicas: readonly Server[],
    nginx: ChildProcess,
    folder: string,
    url: string,
  ) {
    this.#data = data;
    this.replicas = replicas;
    this.#nginx = nginx;
    this.#folder = folder;
    this.url = url;
  }

  static async start(): Promise<Gateway> {
    const data = await Server.start(0, STORE, ["--no-render"]);
    const replicas = [await Server.start(0, data.url), await Server.start(0, data.url)];
    const [web, grpc] = [await freePort(), await freePort()];
    const folder = fs.mkdtempSync(path.join(os.tmpdir(), "flaneur-gateway-"));
    const names: [string, string][] = [
      ["/tmp/", `${folder}/`],
      ["data:7878 resolve", new URL(data.url).host],
      ["listen 8080;", `listen 127.0.0.1:${web};`],
      ["listen 8081 http2;", `listen 127.0.0.1:${grpc} http2;`],
    ];
    for (const [index, { url }] of replicas.entries()) {
      names.push([`render-${index + 1}:7878 resolve`, new URL(url).host]);
    }
    let text = fs.readFileSync(path.join(ROOT, "deploy/nginx.conf"), "utf8");
    for (const [name, here] of names) {
      if (!text.includes(name)) {
        throw new Error(`deploy/nginx.conf does not say ${name}`);
      }
      text = text.replaceAll(name, here);
    }
    const file = path.join(folder, "nginx.conf");
    fs.writeFileSync(file, text);
    // Debian puts it where only the administrator's shell looks.
    const program = fs.existsSync("/usr/sbin/nginx") ? "/usr/sbin/nginx" : "nginx";
    const nginx = spawn(program, ["-g", "daemon off;", "-p", folder, "-c", file], {
      stdio: "ignore",
    });
    await listens(web);
    return new Gateway(data, replicas, nginx, folder, `http://127.0.0.1:${web}`);
  }

  async stop(): Promise<void> {
    // Its workers end with it only where it is asked, not where it is killed.
    const gone = once(this.#nginx, "exit");
    this.#nginx.kill("SIGTERM");
    await gone;
    for (const server of [...this.replicas, this.#data]) {
      await server.kill();
    }
    fs.rmSync(this.#folder, { recursive: true });
  }
}

async function freePort(): Promise<number> {
  const server = net.createServer().listen(0, "127.0.0.1");
  await once(server, "listening");
  const address = server.address();
  server.close();
  await once(server, "close");
  if (address === null || typeof address === "string") {
    throw new Error("no port");
  }
  return address.port;
}

async function listens(port: number): Promise<void> {
  const until = Date.now() + PATIENCE_MS;
  for (;;) {
    const socket = net.connect(port, "127.0.0.1");
    const [event] = await Promise.race([
      once(socket, "connect").then(() => ["connect"]),
      once(socket, "close").then(() => ["close"]),
    ]).catch(() => ["error"]);
    socket.destroy();
    if (event === "connect") {
      return;
    }
    if (Date.now() > until) {
      throw new Error(`nginx does not listen at ${port}`);
    }
    await new Promise((resolve) => setTimeout(resolve, 20));
  }
}
