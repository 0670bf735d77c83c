/** What the audit log, the tasks, the watch, the promises and the figures say beside what the panel says. */
import type { en } from "../../manager/en";
import { type Tables, textsOf } from "../../speech";
import type { records } from "./en";

export { format } from "../../speech";
export const { t, n, word } = textsOf<typeof en & typeof records>();

export const tables: Tables = {
  en: async () => (await import("./en")).records,
  de: async () => (await import("./de")).records,
  es: async () => (await import("./es")).records,
};
