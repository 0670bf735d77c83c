/** What a person reads when a request failed. */
import { Problem } from "../api/problem";
import { t } from "../text/manager";

/** A refusal in one sentence that names what was refused. */
export function refusedText(name: string, error: unknown): string {
  const reasons = error instanceof Problem ? error.errors.map(({ reason }) => reason) : [];
  return t("refused.since", { name, reason: reasons.length > 0 ? reasons.join("; ") : problemText(error) });
}

export function problemText(error: unknown): string {
  if (!(error instanceof Problem)) return String(error);
  if (error.status === 0) return t("publish.unreachable");
  if (error.status === 412) return t("publish.changed");
  return error.status === 401 ? t("publish.login") : error.message;
}
