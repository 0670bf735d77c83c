/** What the view of people and keys says beside what its panel says. */
import type { en } from "../../manager/en";
import { type Tables, textsOf } from "../../speech";
import type { people } from "./en";

export { format } from "../../speech";
export const { t, n, word } = textsOf<typeof en & typeof people>();

export const tables: Tables = {
  en: async () => (await import("./en")).people,
  de: async () => (await import("./de")).people,
  es: async () => (await import("./es")).people,
};
