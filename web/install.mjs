// node install.mjs FOLDER: installs what FOLDER/package-lock.json pins, by the npm on PATH. Where there is none, npm
// itself is fetched first: Debian's package of it brings 400 others.
import { execFileSync } from "node:child_process";
import { createHash } from "node:crypto";
import { existsSync, mkdirSync, writeFileSync } from "node:fs";
import { delimiter, join, resolve } from "node:path";

const version = "10.9.4";
const sha512 = "OnUG836FwboQIbqtefDNlyR0gTHzIfwRfE3DuiNewBvnMnWEpB0VEXwBlFVgqpNzIgYo/MHh3d2Hel/pszapAA==";

const folder = resolve(process.argv[2]);
const found = process.env.PATH.split(delimiter).map((place) => join(place, "npm")).find((file) => existsSync(file));

// Fetches npm into FOLDER/npm; returns its program.
async function fetched() {
  const address = `https://registry.npmjs.org/npm/-/npm-${version}.tgz`;
  const answer = await fetch(address).catch((error) => {
    throw new Error(`${address}: ${error.cause?.message ?? error.message}`);
  });
  if (!answer.ok) throw new Error(`${address}: ${answer.status} ${answer.statusText}`);
  const archive = Buffer.from(await answer.arrayBuffer());
  if (createHash("sha512").update(archive).digest("base64") !== sha512)
    throw new Error(`${address}: is not the file that web/install.mjs knows`);
  const place = join(folder, "npm");
  mkdirSync(place, { recursive: true });
  writeFileSync(join(place, "npm.tgz"), archive);
  execFileSync("tar", ["-xzf", "npm.tgz", "--strip-components=1"], { cwd: place });
  return join(place, "bin", "npm-cli.js");
}

try {
  const [program, first] = found ? [found, []] : [process.execPath, [await fetched()]];
  // No script of a package runs. (esbuild's own only checks what npm has installed.)
  execFileSync(program,
    [...first, "ci", "--prefix", folder, "--include=dev", "--ignore-scripts", "--no-audit", "--no-fund",
      "--loglevel=error"],
    { stdio: "inherit", cwd: folder });
} catch (error) {
  console.error(`web/install.mjs: ${error.message}`);
  process.exit(1);
}
