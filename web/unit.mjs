// node unit.mjs FOLDER: type-checks all and runs tests/*.test.ts, with FOLDER/node_modules.
import { spawnSync } from "node:child_process";
import { readdirSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

const folder = resolve(process.argv[2]);
const web = dirname(fileURLToPath(import.meta.url));
const run = (...words) => spawnSync(process.execPath, words, { stdio: "inherit" }).status ?? 1;
const types = run(join(web, "check.mjs"), folder);
const esbuild = createRequire(join(folder, "package.json"))("esbuild");
const tests = readdirSync(join(web, "tests")).filter((name) => name.endsWith(".test.ts"));
await esbuild.build({
  entryPoints: tests.map((name) => join(web, "tests", name)), bundle: true, platform: "node", format: "esm",
  outdir: join(folder, "tests"), outExtension: { ".js": ".mjs" }, nodePaths: [join(folder, "node_modules")], logLevel: "warning",
});
const units = run("--test", ...tests.map((name) => join(folder, "tests", name.replace(/ts$/, "mjs"))));
process.exit(types || units);
