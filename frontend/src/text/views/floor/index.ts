/** What the cards of the floor say beside what the panel says. */
import type { en } from "../../manager/en";
import { type Tables, textsOf } from "../../speech";
import type { floor } from "./en";

export { format } from "../../speech";
export const { t, n, word } = textsOf<typeof en & typeof floor>();

export const tables: Tables = {
  en: async () => (await import("./en")).floor,
  de: async () => (await import("./de")).floor,
  es: async () => (await import("./es")).floor,
};
