/** What is wrong with a spreadsheet or with a field of a form, beside what the panel says. */
import type { en } from "../../manager/en";
import { type Tables, textsOf } from "../../speech";
import type { rows } from "./en";

export { format } from "../../speech";
export const { t, n, word } = textsOf<typeof en & typeof rows>();

export const tables: Tables = {
  en: async () => (await import("./en")).rows,
  de: async () => (await import("./de")).rows,
  es: async () => (await import("./es")).rows,
};
