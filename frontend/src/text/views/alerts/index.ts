/** What the page of alerts, and how they are told, say beside what the panel says. */
import type { en } from "../../manager/en";
import { type Tables, textsOf } from "../../speech";
import type { alerts } from "./en";

export { format } from "../../speech";
export const { t, n, word } = textsOf<typeof en & typeof alerts>();

export const tables: Tables = {
  en: async () => (await import("./en")).alerts,
  de: async () => (await import("./de")).alerts,
  es: async () => (await import("./es")).alerts,
};
