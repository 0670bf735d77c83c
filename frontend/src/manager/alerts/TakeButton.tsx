import { useLayoutEffect, useRef } from "preact/hooks";
import type { AlertView } from "../../api/types";
import { t } from "../../text/manager";
import { nextAfter } from "./next-alert";
import { subjectOf } from "./subject";
import { take, taking } from "./take";

interface Props {
  alert: AlertView;
  /** What is wrong, for those who cannot see beside what the button stands. */
  what: string;
}

/** It goes when the alert is taken, by whomever; a keyboard that was on it goes on at the next alert. */
export function TakeButton({ alert, what }: Props) {
  const button = useRef<HTMLButtonElement>(null);
  const asked = taking.value.has(alert.id);
  useLayoutEffect(() => {
    const there = button.current;
    return () => {
      if (there && document.activeElement === there) nextAfter(there)?.focus();
    };
  }, []);
  return (
    <button
      ref={button}
      type="button"
      class="button small take"
      // Not disabled, which would take the focus away from it.
      aria-disabled={asked}
      aria-label={t("alerts.takeOf", { subject: subjectOf(alert), what })}
      onClick={() => {
        if (!asked) void take(alert.id);
      }}
    >
      {t("alerts.take")}
    </button>
  );
}
