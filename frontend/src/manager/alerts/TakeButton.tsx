import type { AlertView } from "../../api/types";
import { t } from "../../text/manager";
import { subjectOf } from "./subject";
import { take, taking } from "./take";

interface Props {
  alert: AlertView;
  /** What is wrong, for those who cannot see beside what the button stands. */
  what: string;
}

export function TakeButton({ alert, what }: Props) {
  return (
    <button
      type="button"
      class="button small take"
      disabled={taking.value.has(alert.id)}
      aria-label={t("alerts.takeOf", { subject: subjectOf(alert), what })}
      onClick={() => void take(alert.id)}
    >
      {t("alerts.take")}
    </button>
  );
}
