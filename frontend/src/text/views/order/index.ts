/** What the list and the page of orders say beside what the panel says. */
import type { en } from "../../manager/en";
import { type Tables, textsOf } from "../../speech";
import type { order } from "./en";

export { format } from "../../speech";
export const { t, n, word } = textsOf<typeof en & typeof order>();

export const tables: Tables = {
  en: async () => (await import("./en")).order,
  de: async () => (await import("./de")).order,
  es: async () => (await import("./es")).order,
};
