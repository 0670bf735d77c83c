/** What lists say of being printed, beside what the panel says. */
import type { en } from "../../manager/en";
import { type Tables, textsOf } from "../../speech";
import type { paper } from "./en";

export { format } from "../../speech";
export const { t, n, word } = textsOf<typeof en & typeof paper>();

export const tables: Tables = {
  en: async () => (await import("./en")).paper,
  de: async () => (await import("./de")).paper,
  es: async () => (await import("./es")).paper,
};
