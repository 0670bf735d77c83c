/**
 * The service worker of the operator panel: lets the panel itself open without a network, and say so.
 *
 * It keeps the page and its files, one set per build, and nothing else: what is asked of `/api` passes it
 * by, so no picture of the plant outlives the page, and no command is ever kept for later. It imports
 * nothing, so that it stays one plain script; the server writes `SHELL` in front of it.
 */

interface Shell {
  /** Changes with every build. */
  readonly version: string;
  /** The page as it is without anybody's data. */
  readonly page: string;
  readonly files: readonly string[];
}

interface Extendable extends Event {
  waitUntil(work: Promise<unknown>): void;
}

interface Fetch extends Extendable {
  readonly request: Request;
  respondWith(answer: Promise<Response>): void;
}

interface Worker {
  readonly SHELL: Shell;
  readonly clients: { claim(): Promise<void> };
  skipWaiting(): Promise<void>;
  addEventListener(kind: "install" | "activate", listener: (event: Extendable) => void): void;
  addEventListener(kind: "fetch", listener: (event: Fetch) => void): void;
}

const worker = self as unknown as Worker;
const { files, page, version } = worker.SHELL;
const NAME = `dray-operator-${version}`;

worker.addEventListener("install", (event) => {
  event.waitUntil(keepShell());
});

worker.addEventListener("activate", (event) => {
  event.waitUntil(forgetOthers());
});

worker.addEventListener("fetch", (event) => {
  const { request } = event;
  if (request.mode === "navigate") event.respondWith(openPage(request));
  else if (files.includes(new URL(request.url).pathname)) event.respondWith(openFile(request));
});

async function keepShell(): Promise<void> {
  const cache = await caches.open(NAME);
  await cache.addAll([page, ...files]);
  await worker.skipWaiting();
}

async function forgetOthers(): Promise<void> {
  const names = await caches.keys();
  const others = names.filter((name) => name.startsWith("dray-operator-") && name !== NAME);
  await Promise.all(others.map((name) => caches.delete(name)));
  await worker.clients.claim();
}

/** The server's page, with its word on who may see it; the kept one only where no answer comes. */
async function openPage(request: Request): Promise<Response> {
  try {
    return await fetch(request);
  } catch {
    return (await caches.match(page)) ?? Response.error();
  }
}

/** Their names tell their content, so a kept one is as good as new. */
async function openFile(request: Request): Promise<Response> {
  return (await caches.match(request)) ?? fetch(request);
}
