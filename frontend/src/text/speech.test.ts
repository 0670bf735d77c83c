/** What is loaded at the same time: whoever is last, nobody's words are lost. */
import { beforeEach, expect, test, vi } from "vitest";
import type * as Speech from "./speech";

type Words = Readonly<Record<string, string>>;

/** A table that comes when it is told to. */
function slow(words: Words) {
  const come: (() => void)[] = [];
  const table = () => new Promise<Words>((resolve) => come.push(() => { resolve(words); }));
  return { tables: { en: table, de: table, es: table }, arrive: (which: number) => { come[which]?.(); } };
}

const settle = () => new Promise((resolve) => { setTimeout(resolve); });
const once = (words: Words) => ({ en: () => Promise.resolve(words), de: () => Promise.resolve(words), es: () => Promise.resolve(words) });
let said: typeof Speech;

beforeEach(async () => {
  vi.resetModules();
  vi.stubGlobal("document", { cookie: "", documentElement: { lang: "" } });
  vi.stubGlobal("navigator", { languages: ["en-GB"] });
  vi.stubGlobal("location", { protocol: "https:" });
  vi.stubGlobal("addEventListener", () => undefined);
  vi.stubGlobal("removeEventListener", () => undefined);
  said = await import("./speech");
  await said.beginToSpeak(once({ panel: "panel" }));
});

test("words of a view that comes later are not taken away by one that was begun before", async () => {
  const { t } = said.textsOf<Words>();
  const first = slow({ first: "first" });
  const before = said.speakAlso(first.tables);
  await settle();
  const after = said.speakAlso(once({ second: "second" }));
  await settle();
  first.arrive(1);
  await after;
  first.arrive(0);
  await before;
  expect(["panel", "first", "second"].map((key) => t(key))).toEqual(["panel", "first", "second"]);
});

test("a view that comes while another language is loaded speaks that one", async () => {
  const german = said.changeLanguage("de");
  await said.speakAlso(once({ view: "view" }));
  await german;
  expect(said.language.value).toBe("de");
});

test("a language whose words the network does not bring is spoken as soon as it does, and none that was chosen before", async () => {
  vi.useFakeTimers();
  let isCut = true;
  const { t } = said.textsOf<Words>();
  await said.speakAlso({
    en: () => Promise.resolve({ view: "view" }),
    de: () => Promise.resolve({ view: "Ansicht" }),
    es: () => (isCut ? Promise.reject(new TypeError("Failed to fetch")) : Promise.resolve({ view: "vista" })),
  });
  void said.changeLanguage("es");
  await vi.advanceTimersByTimeAsync(10_000);
  expect([said.language.value, t("view")]).toEqual(["en", "view"]);
  void said.changeLanguage("de");
  await vi.advanceTimersByTimeAsync(0);
  expect([said.language.value, t("view")]).toEqual(["de", "Ansicht"]);
  isCut = false;
  await vi.advanceTimersByTimeAsync(10_000);
  expect(said.language.value).toBe("de");
  void said.changeLanguage("es");
  await vi.advanceTimersByTimeAsync(0);
  expect(t("view")).toBe("vista");
  vi.useRealTimers();
});
