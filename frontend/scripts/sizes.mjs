// Says how large the script of each built page is, compressed, and fails where one is too large.
import { existsSync, readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";

// 0.2 s at 5 Mbit/s; reading and compiling it takes a tablet about as long again.
const MOST_BYTES = 120_000;

const built = fileURLToPath(new URL("../../backend/dray/gateway/static/", import.meta.url));
if (!existsSync(`${built}.vite/manifest.json`)) {
  console.error("There are no built panels to weigh: run `make panels` first.");
  process.exit(1);
}
const chunks = JSON.parse(readFileSync(`${built}.vite/manifest.json`, "utf8"));

const bytesOf = (name) => gzipSync(readFileSync(built + chunks[name].file)).length;
const isLanguage = (name) => name.startsWith("src/text/");

// What is loaded with a chunk, and by and by after it.
function loadedWith(name, without = () => false, found = new Set()) {
  if (found.has(name) || without(name)) return found;
  found.add(name);
  for (const next of [...(chunks[name].imports ?? []), ...(chunks[name].dynamicImports ?? [])]) loadedWith(next, without, found);
  return found;
}

const sum = (names) => names.filter((name) => chunks[name].file.endsWith(".js")).reduce((bytes, name) => bytes + bytesOf(name), 0);

// All that a page may load by and by, but one language only: its longest, with what only languages share.
function bytesOfPage(entry) {
  const page = loadedWith(entry, isLanguage);
  const languages = [...loadedWith(entry)].filter(isLanguage);
  const words = languages.map((name) => sum([...loadedWith(name)].filter((each) => !page.has(each))));
  return sum([...page]) + Math.max(0, ...words);
}

let tooLarge = false;
for (const [name, chunk] of Object.entries(chunks)) {
  if (!chunk.isEntry) continue;
  const bytes = bytesOfPage(name);
  tooLarge ||= bytes > MOST_BYTES;
  console.log(`${(bytes / 1000).toFixed(1).padStart(6)} kB of ${MOST_BYTES / 1000} kB, gzip: ${name}`);
}
if (tooLarge) {
  console.error("A page's script is too large: leave something out, or load it when it is needed.");
  process.exit(1);
}
