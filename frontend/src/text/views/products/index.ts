/** What the view of products says beside what its panel says. */
import type { en } from "../../manager/en";
import { type Tables, textsOf } from "../../speech";
import type { products } from "./en";

export { format } from "../../speech";
export const { t, n, word } = textsOf<typeof en & typeof products>();

export const tables: Tables = {
  en: async () => (await import("./en")).products,
  de: async () => (await import("./de")).products,
  es: async () => (await import("./es")).products,
};
