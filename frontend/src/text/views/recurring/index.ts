/** What the view of recurring work says beside what its panel says. */
import type { en } from "../../manager/en";
import { type Tables, textsOf } from "../../speech";
import type { recurring } from "./en";

export { format } from "../../speech";
export const { t, n, word } = textsOf<typeof en & typeof recurring>();

export const tables: Tables = {
  en: async () => (await import("./en")).recurring,
  de: async () => (await import("./de")).recurring,
  es: async () => (await import("./es")).recurring,
};
