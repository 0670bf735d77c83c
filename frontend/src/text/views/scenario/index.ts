/** What the card of a scenario that is played says beside what the panel says. */
import type { en } from "../../manager/en";
import { type Tables, textsOf } from "../../speech";
import type { scenario } from "./en";

export { format } from "../../speech";
export const { t, n, word } = textsOf<typeof en & typeof scenario>();

export const tables: Tables = {
  en: async () => (await import("./en")).scenario,
  de: async () => (await import("./de")).scenario,
  es: async () => (await import("./es")).scenario,
};
