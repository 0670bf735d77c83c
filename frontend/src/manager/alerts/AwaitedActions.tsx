import { useSignal } from "@preact/signals";
import { carryAway } from "../../api/client";
import { isCutOff } from "../../parts/Carrying";
import { t } from "../../text/views/alerts";
import { Sure } from "../parts/Sure";
import { problemText } from "../problem-text";

/** Of a vehicle that was never heard there is no card: that it is off the floor is said where it is told. Why it cannot be said now stands once, above all rows. */
export function AwaitedActions({ atv }: { atv: string }) {
  const state = useSignal<"idle" | "asking" | "busy" | "done">("idle");
  const failed = useSignal("");
  const say = async () => {
    state.value = "busy";
    failed.value = "";
    try {
      await carryAway(atv);
      state.value = "done";
    } catch (error) {
      state.value = "idle";
      failed.value = t("carry.failed", { reason: problemText(error) });
    }
  };
  if (state.value === "done") return <p role="status">{t("alerts.awaited.done")}</p>;
  return (
    <>
      {state.value === "idle" ? (
        <button type="button" class="button small" disabled={isCutOff()} onClick={() => (state.value = "asking")}>
          {t("alerts.awaited.open", { atv })}
        </button>
      ) : (
        <Sure
          asked={t("alerts.awaited.sure", { atv })}
          no={t("alerts.awaited.not")}
          yes={t("carry.do")}
          busy={state.value === "busy"}
          blocked={isCutOff()}
          onNo={() => (state.value = "idle")}
          onYes={() => void say()}
        />
      )}
      {failed.value !== "" && (
        <span class="complaint" role="alert">
          {failed.value}
        </span>
      )}
    </>
  );
}
