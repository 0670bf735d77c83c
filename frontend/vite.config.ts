import { fileURLToPath } from "node:url";
import { defineConfig } from "vitest/config";
import { sharedBy } from "./scripts/shared-by";

const NO_TRANSITIONS = fileURLToPath(new URL("src/plant/surface/no-transitions.ts", import.meta.url));

/**
 * The panels are built into the gateway's package, with a manifest from which the server's
 * templates learn the hashed names. Nothing is loaded from elsewhere at run time.
 */
export default defineConfig({
  base: "/static/",
  publicDir: "public",
  resolve: { alias: { "d3-transition": NO_TRANSITIONS, "d3-interpolate": NO_TRANSITIONS } },
  build: {
    outDir: "../backend/dray/gateway/static",
    emptyOutDir: true,
    manifest: true,
    modulePreload: false,
    target: "es2022",
    // Fonts and icons stay files: a data: URL would need an exception in the content policy.
    assetsInlineLimit: 0,
    rolldownOptions: {
      input: [
        "src/theme/init.ts",
        "src/manager/main.tsx",
        "src/editor/main.tsx",
        "src/operator/main.tsx",
        "src/operator/shell/worker.ts",
        "src/customer/main.ts",
        "src/login/main.ts",
      ],
      output: { codeSplitting: { includeDependenciesRecursively: false, groups: [{ name: sharedBy, debugName: "shared by pages" }] } },
    },
  },
  test: { include: ["src/**/*.test.ts"], setupFiles: "src/text/in-english.ts" },
});
