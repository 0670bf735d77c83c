import { useSignal } from "@preact/signals";
import { useId } from "preact/hooks";
import type { AtvView } from "../../../api/types";
import { hindranceOf, type VehicleKind } from "../../../commands/hindrance";
import { afterSent } from "../../../parts/sent";
import { isLost } from "../../../plant/silence";
import { isPast } from "../../../stream/freshness";
import { freshness, presentS, world } from "../../../stream/stream";
import { format, t } from "../../../text/manager";
import { inFactoryTime } from "../../../text/plant-time";
import { busy, said, tell } from "./tell";

/** Parts of the vehicle's own top speed. */
const STEPS = [0.25, 0.5, 0.75, 1];
/** The vehicle answers with the very number that it was told. */
const SAME = 1e-6;
/** As much as the gateway takes. */
const REASON_CHARS = 200;
const HOUR_S = 3600;

/** What a person may tell a vehicle, and its word on it. A stop is offered whatever its chances are. */
export function VehicleActs({ atv }: { atv: AtvView }) {
  const hindered = hindrancesOf(atv);
  const act = (kind: "stop" | "acknowledge" | "resume" | "charge" | "put_in") => (
    <button type="button" class={`button ${kind === "stop" ? "stop-act" : ""}`} disabled={hindered(kind)} onClick={() => void tell(atv.id, { kind })}>
      {t(`tell.${kind}`)}
    </button>
  );
  const word = said.value.get(atv.id);
  return (
    <div class="vehicle-acts">
      <p class="faint">{t("tell.noEmergency")}</p>
      <div class="acts-row">
        {act("stop")}
        {act("acknowledge")}
        {act("resume")}
      </div>
      <div class="acts-row" role="group" aria-label={t("tell.speed")}>
        {STEPS.map((step) => (
          <button
            key={step}
            type="button"
            class="button"
            aria-pressed={Math.abs(atv.speed_limit_frac - step) < SAME}
            aria-label={t("tell.speedOf", { percent: format.percent(step) })}
            disabled={hindered("set_speed")}
            onClick={() => void tell(atv.id, { kind: "set_speed", speed_frac: step })}
          >
            {format.percent(step)}
          </button>
        ))}
      </div>
      <div class="acts-row">
        {act("charge")}
        {act("put_in")}
      </div>
      <TakeOut atv={atv} hindered={hindered("take_out")} />
      <p class={`outcome ${word?.good === false ? "outcome-bad" : ""}`} role="status">
        {busy.value ? t("tell.sent") : (word?.text ?? "")}
      </p>
    </div>
  );
}

function hindrancesOf(atv: AtvView) {
  const around = {
    connected: !isPast(freshness.value) && freshness.value !== "connecting",
    ended: false,
    lost: isLost(atv, presentS.value, world.value?.factory.speed ?? 1),
  };
  return (kind: VehicleKind) => kind !== "stop" && (busy.value || hindranceOf(kind, atv, around) !== null);
}

/** Out of service: why, for how long if that is known, and whether it ends its work before. */
function TakeOut({ atv, hindered }: { atv: AtvView; hindered: boolean }) {
  const reason = useSignal("");
  const hours = useSignal("");
  const afterWork = useSignal(true);
  const id = useId();
  const send = async () => {
    const sent = { reason: reason.value, hours: hours.value };
    const back = sent.hours === "" ? {} : { wait_s: Number(sent.hours) * HOUR_S };
    if (!(await tell(atv.id, { kind: "take_out", reason: sent.reason.trim(), after_work: afterWork.value, ...back }))) return;
    reason.value = afterSent(sent.reason, reason.value, "");
    hours.value = afterSent(sent.hours, hours.value, "");
  };
  return (
    <form
      class="take-out"
      onSubmit={(event) => {
        event.preventDefault();
        if (!hindered) void send();
      }}
    >
      <div class="field">
        <label for={`${id}-reason`}>{t("tell.reason")}</label>
        <input id={`${id}-reason`} required autoComplete="off" maxLength={REASON_CHARS} value={reason.value} onInput={(event) => { reason.value = event.currentTarget.value; }} />
      </div>
      <div class="field">
        <label for={`${id}-hours`}>{inFactoryTime(t("tell.hours"))}</label>
        <input id={`${id}-hours`} type="number" min="0.1" max="700" step="any" value={hours.value} onInput={(event) => { hours.value = event.currentTarget.value; }} />
      </div>
      <label class="check">
        <input type="checkbox" checked={afterWork.value} onChange={(event) => { afterWork.value = event.currentTarget.checked; }} />
        {t("tell.afterWork")}
      </label>
      <button type="submit" class="button" disabled={hindered || reason.value.trim() === ""}>
        {t("tell.take_out")}
      </button>
    </form>
  );
}
