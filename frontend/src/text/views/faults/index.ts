/** What the panel of a simulated factory says of faults that people begin. */
import type { en } from "../../manager/en";
import { type Tables, textsOf } from "../../speech";
import type { faults } from "./en";

export { format } from "../../speech";
export const { t, n, word } = textsOf<typeof en & typeof faults>();

export const tables: Tables = {
  en: async () => (await import("./en")).faults,
  de: async () => (await import("./de")).faults,
  es: async () => (await import("./es")).faults,
};
