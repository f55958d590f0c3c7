import fs from "node:fs";
import path from "node:path";
import type { Plugin } from "vite";

/** Writes `licences.txt`: what the licences of all bundled packages ask to be passed on. */
export function licences(): Plugin {
  return {
    name: "licences",
    generateBundle(_options, bundle) {
      const packages = new Map<string, string>();
      for (const file of Object.values(bundle)) {
        for (const id of file.type === "chunk" ? file.moduleIds : []) {
          const [, folder] = /^\0?(.*\/node_modules\/(?:@[^/]+\/)?[^/]+)\//.exec(id) ?? [];
          if (folder && !packages.has(folder)) {
            packages.set(folder, licenceOf(folder));
          }
        }
      }
      const source = [...packages.values()].sort().join(`\n${"-".repeat(80)}\n\n`);
      this.emitFile({ type: "asset", fileName: "licences.txt", source });
    },
  };
}

/** Name, version and licence of the package in a folder; fails where it has none. */
function licenceOf(folder: string): string {
  const { name, version, license } = JSON.parse(
    fs.readFileSync(path.join(folder, "package.json"), "utf8"),
  );
  const files = fs.readdirSync(folder).filter((file) => /^(licen[cs]e|notice)/i.test(file));
  if (!license) {
    throw new Error(`${folder} names no licence`);
  }
  const texts = files.map((file) => fs.readFileSync(path.join(folder, file), "utf8").trim());
  return `${[`${name} ${version}: ${license}`, ...texts].join("\n\n")}\n`;
}
