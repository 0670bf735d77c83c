// Says how large the script of each built page is, compressed, and in how many files, and fails where it is too much.
import { existsSync, readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";

// 0.2 s at 5 Mbit/s; reading and compiling it takes a tablet about as long again.
const MOST_BYTES = 100_000;
// A view that is loaded when somebody looks at it.
const MOST_LATER_BYTES = 40_000;
// At once: a browser asks for six at a time over HTTP/1.1, and over a thin line each turn costs a way there and back.
const MOST_FILES = 6;

const built = fileURLToPath(new URL("../../backend/dray/gateway/static/", import.meta.url));
if (!existsSync(`${built}.vite/manifest.json`)) {
  console.error("There are no built panels to weigh: run `make panels` first.");
  process.exit(1);
}
const chunks = JSON.parse(readFileSync(`${built}.vite/manifest.json`, "utf8"));

const bytesOf = (name) => gzipSync(readFileSync(built + chunks[name].file)).length;
const isLanguage = (name) => name.startsWith("src/text/");

// What is loaded with a chunk.
function loadedWith(name, found = new Set()) {
  if (found.has(name)) return found;
  found.add(name);
  for (const next of chunks[name].imports ?? []) loadedWith(next, found);
  return found;
}

// What is loaded after it: languages, and views when somebody looks at them.
const loadedAfter = (names) => new Set([...names].flatMap((name) => chunks[name].dynamicImports ?? []));

const sum = (names) => names.filter((name) => chunks[name].file.endsWith(".js")).reduce((bytes, name) => bytes + bytesOf(name), 0);

let tooLarge = false;
function weigh(name, names, mostBytes) {
  const bytes = sum(names);
  tooLarge ||= bytes > mostBytes;
  console.log(`${(bytes / 1000).toFixed(1).padStart(6)} kB of ${mostBytes / 1000} kB, gzip: ${name}`);
}

for (const [name, chunk] of Object.entries(chunks)) {
  if (!chunk.isEntry) continue;
  const page = loadedWith(name);
  const after = [...loadedAfter(page)];
  const besides = (each) => [...loadedWith(each)].filter((part) => !page.has(part));
  // One language only: its longest, with what only languages share.
  const words = after.filter(isLanguage).map(besides).sort((a, b) => sum(b) - sum(a))[0] ?? [];
  weigh(name, [...page, ...words], MOST_BYTES);
  if (page.size > MOST_FILES) {
    tooLarge = true;
    console.error(`${page.size} of ${MOST_FILES} files: ${name}; scripts/shared-by.ts puts together what pages share`);
  }
  for (const view of after.filter((each) => !isLanguage(each))) weigh(`${view}, when it is looked at`, besides(view), MOST_LATER_BYTES);
}
if (tooLarge) {
  console.error("A page's script is too large: leave something out, or load a part of it when that is looked at.");
  process.exit(1);
}
