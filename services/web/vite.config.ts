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
  test: { include: ["src/**/*.test.ts"] },
});
