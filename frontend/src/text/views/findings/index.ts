/** What is to be seen to in a draft of a plant. */
import type { Tables } from "../../speech";

export const tables: Tables = {
  en: async () => (await import("./en")).findings,
  de: async () => (await import("./de")).findings,
  es: async () => (await import("./es")).findings,
};
