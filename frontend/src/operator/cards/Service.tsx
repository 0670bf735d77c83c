import { useSignal } from "@preact/signals";
import type { AtvView } from "../../api/types";
import { format, t } from "../../text/operator";
import { give } from "../commands/given";
import { hindranceOf } from "../commands/hindrance";
import { circumstancesOf, moment } from "../state";
import { HoldButton } from "./HoldButton";

/** Why a vehicle is taken out of service; whoever needs other words has the management panel. */
const REASONS = ["maintenance", "repair", "cleaning", "place"] as const;

/** For how long: hours; null for as long as it takes. */
const HOURS = [1, 8, null] as const;

/** Out of service, by a person's word: first why, and then for how long, which sends it. Back by press and hold. */
export function Service({ atv }: { atv: AtvView }) {
  return atv.out_of_service ? <Back atv={atv} /> : <Out atv={atv} />;
}

function Out({ atv }: { atv: AtvView }) {
  const open = useSignal(false);
  const reason = useSignal<(typeof REASONS)[number] | null>(null);
  const afterWork = useSignal(false);
  const disabled = hindranceOf("take_out", atv, circumstancesOf(atv)) !== null;
  const send = (hours: number | null): void => {
    const why = reason.value;
    if (why === null) return;
    open.value = false;
    reason.value = null;
    const back = hours === null ? {} : { wait_s: hours * 3600 };
    void give(atv.id, { kind: "take_out", reason: t(`service.reason.${why}`), after_work: afterWork.value, ...back });
  };
  if (!open.value)
    return (
      <button
        type="button"
        class="button service-open"
        disabled={disabled}
        onClick={() => {
          open.value = true;
        }}
      >
        {t("service.out")}
      </button>
    );
  return (
    <div class="service" role="group" aria-label={t("service.outOf", { atv: atv.id })}>
      <span aria-hidden="true">{t("service.why")}</span>
      {REASONS.map((each) => (
        <button
          key={each}
          type="button"
          class="button"
          aria-pressed={reason.value === each}
          onClick={() => {
            reason.value = each;
          }}
        >
          {t(`service.reason.${each}`)}
        </button>
      ))}
      {atv.task && (
        <button
          type="button"
          class="button after-work"
          aria-pressed={afterWork.value}
          onClick={() => {
            afterWork.value = !afterWork.value;
          }}
        >
          {t("service.afterWork")}
        </button>
      )}
      <span aria-hidden="true">{t("service.until")}</span>
      {HOURS.map((hours) => (
        <button key={hours} type="button" class="button" disabled={disabled || reason.value === null} onClick={() => {
          send(hours);
        }}>
          {hours === null ? t("service.open") : t("service.hours", { hours })}
        </button>
      ))}
      <button
        type="button"
        class="button"
        onClick={() => {
          open.value = false;
          reason.value = null;
        }}
      >
        {t("service.leave")}
      </button>
    </div>
  );
}

function Back({ atv }: { atv: AtvView }) {
  const out = atv.out_of_service;
  if (!out) return null;
  const { nowS } = moment.value;
  const said = { by: out.by, since: format.due(out.since_at_s, nowS) };
  return (
    <div class="service-back">
      <p>
        {out.reason === "" ? t("service.since", said) : t("service.sinceWhy", { ...said, reason: out.reason })}
        {out.back_at_s !== null && ` ${t("service.back", { at: format.due(out.back_at_s, nowS) })}`}
      </p>
      <HoldButton
        class="button"
        disabled={hindranceOf("put_in", atv, circumstancesOf(atv)) !== null}
        onHeld={() => void give(atv.id, { kind: "put_in" })}
      >
        <span>{t("service.in")}</span> <small>{t("release.hold")}</small>
      </HoldButton>
    </div>
  );
}
