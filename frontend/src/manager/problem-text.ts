/** What a person reads when a request failed. */
import { Problem } from "../api/problem";
import { t } from "../text/manager";

export function problemText(error: unknown): string {
  if (!(error instanceof Problem)) return String(error);
  if (error.status === 0) return t("publish.unreachable");
  if (error.status === 412) return t("publish.changed");
  return error.status === 401 ? t("publish.login") : error.message;
}
