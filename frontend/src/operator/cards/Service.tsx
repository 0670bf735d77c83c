import { useSignal } from "@preact/signals";
import type { AtvView, CommandRequest, OutOfServiceView } from "../../api/types";
import { format, t } from "../../text/operator";
import { inFactoryTime } from "../../text/plant-time";
import { give } from "../commands/given";
import { hindranceOf } from "../../commands/hindrance";
import { circumstancesOf, moment } from "../state";
import { Checks } from "./Checks";
import { forms, REASONS, setForm } from "./forms";
import { HoldButton } from "./HoldButton";

/** For how long: hours; null for as long as it takes. */
const HOURS = [1, 8, null] as const;

/** What a vehicle and a machine may be told about it. */
type Word = Pick<CommandRequest, "reason" | "wait_s" | "after_work"> & { readonly kind: "take_out" | "put_in" };

interface Props {
  readonly id: string;
  readonly out: OutOfServiceView | null;
  readonly hindered: boolean;
  /** What it may finish first; null for nothing. */
  readonly finishes: string | null;
  /** What somebody looks at before it is in service again. */
  readonly checks: readonly string[];
  readonly send: (word: Word) => void;
}

/** A vehicle in or out of service; one that has left is told nothing from here. */
export function Service({ atv, left }: { atv: AtvView; left: boolean }) {
  const kind = atv.out_of_service ? "put_in" : "take_out";
  return (
    <ServiceActs
      id={atv.id}
      out={atv.out_of_service}
      hindered={left || hindranceOf(kind, atv, circumstancesOf(atv)) !== null}
      finishes={atv.task ? t("service.afterWork") : null}
      checks={[t("check.vehicle.mended"), t("check.vehicle.load"), t("check.vehicle.clear")]}
      send={(word) => void give(atv.id, word)}
    />
  );
}

/** Out of service, by a person's word: first why, and then for how long, which sends it. Back by a list, and press and hold. */
export function ServiceActs(props: Props) {
  return props.out ? <Back {...props} out={props.out} /> : <Out {...props} />;
}

function Out({ finishes, hindered: disabled, id, send: say }: Props) {
  const form = forms.value.get(id);
  const send = (hours: number | null): void => {
    if (!form?.reason) return;
    setForm(id, null);
    const back = hours === null ? {} : { wait_s: hours * 3600 };
    say({ kind: "take_out", reason: t(`service.reason.${form.reason}`), after_work: form.afterWork, ...back });
  };
  if (!form)
    return (
      <button
        type="button"
        class="button service-open"
        disabled={disabled}
        onClick={() => {
          setForm(id, { reason: null, afterWork: false });
        }}
      >
        {t("service.out")}
      </button>
    );
  return (
    <div class="service" role="group" aria-label={t("service.outOf", { atv: id })}>
      <span aria-hidden="true">{t("service.why")}</span>
      {REASONS.map((each) => (
        <button
          key={each}
          type="button"
          class="button"
          aria-pressed={form.reason === each}
          onClick={() => {
            setForm(id, { ...form, reason: each });
          }}
        >
          {t(`service.reason.${each}`)}
        </button>
      ))}
      {finishes !== null && (
        <button
          type="button"
          class="button after-work"
          aria-pressed={form.afterWork}
          onClick={() => {
            setForm(id, { ...form, afterWork: !form.afterWork });
          }}
        >
          {finishes}
        </button>
      )}
      <span aria-hidden="true">{inFactoryTime(t("service.until"))}</span>
      {HOURS.map((hours) => (
        <button key={hours} type="button" class="button" disabled={disabled || form.reason === null} onClick={() => {
          send(hours);
        }}>
          {hours === null ? t("service.open") : t("service.hours", { hours })}
        </button>
      ))}
      <button
        type="button"
        class="button"
        onClick={() => {
          setForm(id, null);
        }}
      >
        {t("service.leave")}
      </button>
    </div>
  );
}

function Back({ checks, hindered, id, out, send }: Props & { readonly out: OutOfServiceView }) {
  const done = useSignal(0);
  const { nowS } = moment.value;
  const said = { by: out.by, since: format.due(out.since_at_s, nowS) };
  return (
    <div class="service-back">
      <p>
        {out.reason === "" ? t("service.since", said) : t("service.sinceWhy", { ...said, reason: out.reason })}
        {out.back_at_s !== null && ` ${t("service.back", { at: format.due(out.back_at_s, nowS) })}`}
      </p>
      <Checks title={t("check.title", { id })} checks={checks} done={done} />
      <HoldButton
        class="button"
        disabled={hindered || done.value < checks.length}
        onHeld={() => {
          send({ kind: "put_in" });
        }}
      >
        <span>{t("service.in")}</span> <small>{t("release.hold")}</small>
      </HoldButton>
    </div>
  );
}
