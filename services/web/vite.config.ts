import { defineConfig } from "vitest/config";
import { licences } from "./build/licences";

export default defineConfig({
  base: "./",
  plugins: [licences()],
  build: {
    target: "es2022",
    // The inset map is a file of its own, and comes after the street.
    chunkSizeWarningLimit: 1200,
  },
  // While the page is being changed, it is not from the server that it calls.
  server: { proxy: { "/flaneur.v1.": process.env.FLANEUR_SERVER ?? "http://127.0.0.1:7878" } },
  test: { include: ["src/**/*.test.ts"] },
});
