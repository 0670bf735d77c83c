/** What a person reads when a request failed, or a vehicle refuses. */
import { Problem } from "../api/problem";
import { failureText } from "../text/failure";
import { t, word } from "../text/operator";

export function problemText(error: unknown): string {
  if (!(error instanceof Problem)) return String(error);
  if (error.status === 0) return t("command.unreachable");
  return error.status === 401 ? t("command.ended") : error.message;
}

/** A vehicle's reason, in the reader's language; else what somebody says in words of their own. */
export function refusalText({ detail, reason }: { readonly reason: string; readonly detail: string }): string {
  if (reason === "faulty") return t("refusal.faulty", { problem: failureText(detail) });
  return reason === "" ? detail : word("refusal", reason);
}
