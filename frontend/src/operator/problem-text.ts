/** What a person reads when a request failed, and in which words a vehicle complains. */
import { Problem } from "../api/client";
import { t, word } from "../text/operator";

export function problemText(error: unknown): string {
  if (!(error instanceof Problem)) return String(error);
  if (error.status === 0) return t("command.unreachable");
  return error.status === 401 ? t("command.ended") : error.message;
}

/** A vehicle's own words for what is wrong. */
export function faultText(problem: string): string {
  return word("problem", problem);
}

/** A vehicle's own words for why it refuses. */
export function refusalText(reason: string): string {
  return word("refusal", reason);
}
