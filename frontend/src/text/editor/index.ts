/** What the plant editor says. */
import { type Tables, textsOf } from "../speech";
import type { en } from "./en";

export { format } from "../speech";
export const { t, n, word } = textsOf<typeof en>();

export const tables: Tables = {
  en: async () => (await import("./en")).en,
  de: async () => (await import("./de")).de,
  es: async () => (await import("./es")).es,
};
