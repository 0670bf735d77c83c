/** What the legend, the tour and the words of the trade say beside what the panel says. */
import type { en } from "../../manager/en";
import { type Tables, textsOf } from "../../speech";
import type { guide } from "./en";

export { format } from "../../speech";
export const { t, n, word } = textsOf<typeof en & typeof guide>();

export const tables: Tables = {
  en: async () => (await import("./en")).guide,
  de: async () => (await import("./de")).guide,
  es: async () => (await import("./es")).guide,
};
