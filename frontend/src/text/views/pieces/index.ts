/** What is said of the pieces of a machine, beside what all panels say. */
import type { en } from "../../shared/en";
import { type Tables, textsOf } from "../../speech";
import type { pieces } from "./en";

export { format } from "../../speech";
export const { t, n, word } = textsOf<typeof en & typeof pieces>();

export const tables: Tables = {
  en: async () => (await import("./en")).pieces,
  de: async () => (await import("./de")).pieces,
  es: async () => (await import("./es")).pieces,
};
