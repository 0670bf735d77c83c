/** What tells for how long history is kept, beside what the panel says. */
import type { en } from "../../manager/en";
import { type Tables, textsOf } from "../../speech";
import type { kept } from "./en";

export { format } from "../../speech";
export const { t, n, word } = textsOf<typeof en & typeof kept>();

export const tables: Tables = {
  en: async () => (await import("./en")).kept,
  de: async () => (await import("./de")).kept,
  es: async () => (await import("./es")).kept,
};
