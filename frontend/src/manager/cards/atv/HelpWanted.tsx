import { useSignal } from "@preact/signals";
import { commandAtv } from "../../../api/client";
import type { HelpView } from "../../../api/types";
import { nowS } from "../../../stream/stream";
import { t, word } from "../../../text/manager";
import { factoryTime } from "../../../text/plant-time";
import { problemText } from "../../problem-text";
import { helpText } from "./help";

/** How long help takes that somebody promises from a desk, in factory seconds; where the vehicle waits so long. */
const PROMISE_S = 300;

/** How long a vehicle waits for a person, and the promise that one comes. */
export function HelpWanted({ atv, help, speed }: { atv: string; help: HelpView; speed: number }) {
  const busy = useSignal(false);
  const failed = useSignal("");
  const promiseS = Math.min(PROMISE_S, help.promise_max_s);
  const promise = async () => {
    busy.value = true;
    failed.value = "";
    try {
      const { detail, done, reason } = await commandAtv(atv, { kind: "promise", wait_s: promiseS });
      if (!done) failed.value = t("atv.promiseFailed", { reason: reason === null ? detail : word("refusal.command", reason) });
    } catch (error) {
      failed.value = t("atv.promiseFailed", { reason: problemText(error) });
    } finally {
      busy.value = false;
    }
  };
  return (
    <>
      <small class="line">{helpText(help, nowS.value, speed)}</small>
      {help.promised_by === "" && (
        <button
          type="button"
          class="button small promise"
          disabled={busy.value}
          title={t("atv.promiseTitle", { left: factoryTime(promiseS, speed) })}
          onClick={() => void promise()}
        >
          {t("atv.promise")}
        </button>
      )}
      {failed.value !== "" && (
        <small class="line" role="alert">
          {failed.value}
        </small>
      )}
    </>
  );
}
