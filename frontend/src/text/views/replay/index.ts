/** What the page of the past says beside what the panel says. */
import type { en } from "../../manager/en";
import { type Tables, textsOf } from "../../speech";
import type { replay } from "./en";

export { format } from "../../speech";
export const { t, n, word } = textsOf<typeof en & typeof replay>();

export const tables: Tables = {
  en: async () => (await import("./en")).replay,
  de: async () => (await import("./de")).replay,
  es: async () => (await import("./es")).replay,
};
