/** What the plant editor says. */
import { type Tables, textsOf } from "../speech";
import { tables as findings } from "../views/findings";
import type { en } from "./en";

export { format } from "../speech";
export const { t, n, word } = textsOf<typeof en>();

export const tables: Tables = {
  en: async () => ({ ...(await findings.en()), ...(await import("./en")).en }),
  de: async () => ({ ...(await findings.de()), ...(await import("./de")).de }),
  es: async () => ({ ...(await findings.es()), ...(await import("./es")).es }),
};
