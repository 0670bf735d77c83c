/** What agents say of what is wrong, in the reader's language; what this version does not know stays as it is. */
import { format, t, word } from "./index";

/** As "M1 is silent": several of them say why an order waits. */
const OF_AGENT = /^(\S+) is (.+)$/;

const NOT_MADE = /^this plant does not make (.+)$/;

export function failureText(reason: string): string {
  const products = NOT_MADE.exec(reason)?.[1];
  if (products !== undefined) return t("failure.notMade", { products: format.list(products.split(" and ")) });
  const parts = reason.split(", ").map((part) => OF_AGENT.exec(part));
  if (!parts.every((part) => part !== null)) return word("failure", reason);
  return format.list(parts.map(([, agent = "", what = ""]) => t("failure.of", { agent, what: word("failure", what) })));
}
