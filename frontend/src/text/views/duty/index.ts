/** What the row of people on duty says beside what the panel says. */
import type { en } from "../../manager/en";
import { type Tables, textsOf } from "../../speech";
import type { duty } from "./en";

export { format } from "../../speech";
export const { t, n, word } = textsOf<typeof en & typeof duty>();

export const tables: Tables = {
  en: async () => (await import("./en")).duty,
  de: async () => (await import("./de")).duty,
  es: async () => (await import("./es")).duty,
};
