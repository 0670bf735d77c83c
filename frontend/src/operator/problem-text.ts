/** What a person reads when a request failed, or a vehicle refuses. */
import { Problem } from "../api/problem";
import { failureText } from "../text/failure";
import { t, word } from "../text/operator";

/** What a vehicle answers to an acknowledge that comes too early. */
const STILL_REPORTS = /^its sensors still report: (.+)$/;

export function problemText(error: unknown): string {
  if (!(error instanceof Problem)) return String(error);
  if (error.status === 0) return t("command.unreachable");
  return error.status === 401 ? t("command.ended") : error.message;
}

/** A vehicle's reason, in the reader's language. */
export function refusalText(reason: string): string {
  const [, problem] = STILL_REPORTS.exec(reason) ?? [];
  if (problem !== undefined) return t("refusal.faulty", { problem: failureText(problem) });
  return word("refusal", reason);
}
