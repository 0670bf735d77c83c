/** What the view of plain transports says beside what its panel says. */
import type { en } from "../../manager/en";
import { type Tables, textsOf } from "../../speech";
import type { transports } from "./en";

export { format } from "../../speech";
export const { t, n, word } = textsOf<typeof en & typeof transports>();

export const tables: Tables = {
  en: async () => (await import("./en")).transports,
  de: async () => (await import("./de")).transports,
  es: async () => (await import("./es")).transports,
};
