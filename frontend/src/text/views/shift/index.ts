/** What the shift report says beside what the panel, the past and the audit log say. */
import type { en } from "../../manager/en";
import { type Tables, textsOf } from "../../speech";
import type { records } from "../records/en";
import type { replay } from "../replay/en";
import type { shift } from "./en";

export { format } from "../../speech";
export const { t, n, word } = textsOf<typeof en & typeof replay & typeof records & typeof shift>();

export const tables: Tables = {
  en: async () => (await import("./en")).shift,
  de: async () => (await import("./de")).shift,
  es: async () => (await import("./es")).shift,
};
