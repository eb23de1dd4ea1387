// node build.mjs FOLDER: makes FOLDER/page.html, of a run, and FOLDER/place.html, of ./impedraw place: each one file with style and program,
// from src/. FOLDER/node_modules holds the packages. src/page/page.cc puts title, data and what a live page connects to in place of the marks.
import { createHash } from "node:crypto";
import { readFileSync, renameSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

const folder = resolve(process.argv[2]);
const web = dirname(fileURLToPath(import.meta.url));
const esbuild = createRequire(join(folder, "package.json"))("esbuild");
const options = {
  bundle: true, minify: true, write: false, charset: "utf8", legalComments: "eof", logLevel: "warning",
  target: ["chrome100", "firefox113", "safari16.4"], nodePaths: [join(folder, "node_modules")],
};
const bundled = async (entry) =>
  (await esbuild.build({ ...options, entryPoints: [join(web, "src", entry)] })).outputFiles[0].text;

// The page can run no other program than its own, and fetch nothing but what its server has.
const write = async (name, program, style) => {
  const script = await bundled(program);
  const hash = createHash("sha256").update(script, "utf8").digest("base64");
  const policy = `default-src 'none'; script-src 'sha256-${hash}'; style-src 'unsafe-inline'; img-src data: blob:`;
  const css = await bundled(style);
  const page = readFileSync(join(web, "src", name), "utf8")
    .replace("@POLICY@", () => policy)
    .replace("@STYLE@", () => css)
    .replace("@PROGRAM@", () => script);
  writeFileSync(join(folder, `${name}.new`), page);
  renameSync(join(folder, `${name}.new`), join(folder, name));
};
await write("place.html", "place.ts", "place.css");
await write("page.html", "main.ts", "style.css");
