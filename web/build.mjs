// node build.mjs FOLDER: makes FOLDER/page.html, one file with style and program, from src/.
// FOLDER/node_modules holds the packages. src/page/page.cc puts title, data and what a live page connects to in place of the marks.
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

const program = await bundled("main.ts");
const style = await bundled("style.css");
// The page can neither fetch anything nor run another program than this one.
const hash = createHash("sha256").update(program, "utf8").digest("base64");
const policy = `default-src 'none'; script-src 'sha256-${hash}'; style-src 'unsafe-inline'; img-src data: blob:@CONNECT@`;
const page = readFileSync(join(web, "src", "page.html"), "utf8")
  .replace("@POLICY@", () => policy)
  .replace("@STYLE@", () => style)
  .replace("@PROGRAM@", () => program);
writeFileSync(join(folder, "page.html.new"), page);
renameSync(join(folder, "page.html.new"), join(folder, "page.html"));
