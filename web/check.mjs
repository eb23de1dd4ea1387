// node check.mjs FOLDER: type-checks src/ and tests/ with the packages in FOLDER/node_modules.
import { spawnSync } from "node:child_process";
import { writeFileSync } from "node:fs";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

const folder = resolve(process.argv[2]);
const web = dirname(fileURLToPath(import.meta.url));
const modules = join(folder, "node_modules");
const config = join(folder, "tsconfig.json");
writeFileSync(config, JSON.stringify({
  extends: join(web, "tsconfig.json"),
  compilerOptions: {
    paths: { three: [join(modules, "@types/three")], "three/*": [join(modules, "@types/three/*")], "*": [join(modules, "*")] },
    typeRoots: [join(modules, "@types")],
  },
  include: [join(web, "src"), join(web, "tests")],
}));
const tsc = spawnSync(process.execPath, [join(modules, "typescript/bin/tsc"), "--project", config, "--pretty", "false"], { stdio: "inherit" });
process.exit(tsc.status ?? 1);
