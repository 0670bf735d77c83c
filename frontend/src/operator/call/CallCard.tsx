import { useEffect } from "preact/hooks";
import type { BufferView, MachineSpec } from "../../api/types";
import type { TransportAnswer } from "../../api/transports";
import { isLow, lastsS } from "../../plant/stock";
import { nowS, world } from "../../stream/stream";
import { vehicleName } from "../../text/elsewhere";
import { format, t, word } from "../../text/operator";
import { placeOf } from "../../text/place";
import { shortageText } from "../../text/shortage";
import { moment, names, plant } from "../state";
import { busy, calls, choice, choose, failed, followCalls, place, send, sent, withdraw } from "./call";
import "./call.css";
import { canCallOff, loadFrom, LOADS, shownCalls, stepOf, STEPS, unwillingOf } from "./steps";
import { ThingForm } from "./ThingForm";

/** Bring and take away for one place: first touch what, second touch, in another place, how much; that sends. */
export function CallCard() {
  useEffect(followCalls, []);
  const spec = place.value;
  if (!spec) return null;
  const machine = world.value?.machines.get(spec.id);
  const buffers = machine?.buffers ?? [];
  const shown = shownCalls(calls.value, nowS.value * 1000);
  return (
    <section class="transport-call card" aria-label={t("calling.title", { place: spec.id })}>
      <header>
        <h2>{t("calling.title", { place: spec.id })}</h2>
      </header>
      <div class="call-what">
        <Tiles buffers={buffers} way="bring" lasts={(item) => (machine ? lastsS(machine, spec, plant.value?.products ?? [], item) : null)} />
        <Tiles buffers={buffers.filter(({ level }) => level > 0)} way="take" lasts={() => null} />
      </div>
      <Second spec={spec} buffers={buffers} />
      <ThingForm />
      {shown.length > 0 && (
        <ul class="call-jobs">
          {shown.map((call) => (
            <Job key={call.id} call={call} place={spec.id} />
          ))}
        </ul>
      )}
    </section>
  );
}

interface TilesProps {
  buffers: readonly BufferView[];
  way: "bring" | "take";
  /** How long what is here lasts, in plant seconds; null where nobody need know. */
  lasts: (item: string) => number | null;
}

function Tiles({ buffers, way, lasts }: TilesProps) {
  if (buffers.length === 0) return null;
  const { nowS: atS, speed } = moment.value;
  const until = (item: string): string => {
    const spanS = lasts(item);
    return spanS === null ? "" : ` · ${t("calling.lasts", { time: format.hour(atS + spanS / speed) })}`;
  };
  return (
    <div role="group" aria-label={t(`calling.${way}`)}>
      <h3>{t(`calling.${way}`)}</h3>
      <div class="call-tiles">
        {buffers.map((buffer) => (
          <button
            key={buffer.item}
            type="button"
            class="call-tile"
            aria-pressed={choice.value?.item === buffer.item && choice.value.way === way}
            onClick={() => { choose(buffer.item, way); }}
          >
            <b>{names.value(buffer.item)}</b>
            <small class={way === "bring" && isLow(buffer) ? "tone-warn" : ""}>
              {t("calling.level", { level: format.count(buffer.level) })}
              {way === "bring" && buffer.on_order > 0 && ` · ${t("calling.coming", { quantity: format.count(buffer.on_order) })}`}
              {until(buffer.item)}
            </small>
          </button>
        ))}
      </div>
    </div>
  );
}

/** The place of the second touch is always there, so that nothing moves under a finger. */
function Second({ buffers, spec }: { buffers: readonly BufferView[]; spec: MachineSpec }) {
  const chosen = choice.value;
  const lot = plant.value?.materials.find(({ id }) => id === chosen?.item)?.lot;
  if (!chosen || lot === undefined) {
    return (
      <div class="call-send" role="status">
        {sent.value !== "" && <p><b>{sent.value}</b></p>}
        <p class={failed.value === "" ? "muted" : "tone-warn"}>{failed.value || t("calling.first")}</p>
      </div>
    );
  }
  const what = names.value(chosen.item);
  const load = chosen.way === "bring" ? lot : loadFrom(buffers, chosen.item, lot);
  return (
    <div class="call-send" role="status">
      <p>
        <b>{t(`calling.${chosen.way}What`, { what, place: spec.id })}</b>{" "}
        <span class={failed.value === "" ? "muted" : "tone-warn"}>{failed.value || t("calling.notSent")}</span>
      </p>
      <div class="call-amounts">
        {(chosen.way === "bring" ? LOADS : [1]).map((loads) => (
          <button key={loads} type="button" class={`button act ${loads === 1 ? "primary" : ""}`} disabled={busy.value} onClick={() => void send(load, loads, false)}>
            {t(`calling.${chosen.way}Amount`, { quantity: format.count(load * loads) })}
          </button>
        ))}
        <button type="button" class="button act" disabled={busy.value} onClick={() => void send(load, 1, true)}>
          {t("calling.urgent", { quantity: format.count(load) })}
        </button>
      </div>
    </div>
  );
}

function Job({ call, place }: { call: TransportAnswer; place: string }) {
  const step = stepOf(call);
  const brought = call.to === place;
  const what = t(brought ? "calling.jobBring" : "calling.jobTake", {
    quantity: format.count(call.quantity), what: call.thing ?? names.value(call.item), place: placeOf(brought ? call.from : call.to),
  });
  return (
    <li>
      <div>
        <b>{what}</b>
        {step === null ? (
          <p class="muted">{t("calling.off")}</p>
        ) : (
          <ol class="call-steps">
            {STEPS.map((name, i) => (
              <li key={name} class={i < step ? "done" : i === step ? "now" : ""} aria-current={i === step ? "step" : undefined}>
                {t(`calling.step.${name === "here" && !brought ? "there" : name}`)}
              </li>
            ))}
          </ol>
        )}
        {why(call) !== "" && <small class={call.wait === null || call.wait === "undecided" || call.wait === "not_before" ? "muted" : "tone-warn"}>{why(call)}</small>}
        {call.shortage !== null && <small class="muted">{shortageText(call.from, brought ? call.shortage : { ...call.shortage, elsewhere: [] })}</small>}
        {call.wait === "no_bid" && <Unwilling task={call.task} />}
      </div>
      {canCallOff(call) && (
        <button type="button" class="button act call-off" disabled={busy.value} onClick={() => void withdraw(call.id)}>
          {t("calling.callOff")}
        </button>
      )}
    </li>
  );
}

/** Which vehicles have not bid for it, and why. */
function Unwilling({ task }: { task: string | null }) {
  return (
    <>
      {unwillingOf(world.value?.tasks.get(task ?? "")).map(({ reason, vehicles }) => (
        <small key={reason} class="call-unwilling muted">
          {t("calling.unwilling", { vehicles: format.list(vehicles.map(vehicleName)), why: word("unwilling", reason) })}
        </small>
      ))}
    </>
  );
}

/** Why it stays where it is, or when it is expected. */
function why(call: TransportAnswer): string {
  if (call.refused !== null) return t("calling.refused");
  if (call.cancel_at !== null && call.ended_at === null) return t("calling.beingOff");
  if (call.ended_at !== null) return "";
  const left = world.value?.tasks.get(call.task ?? "")?.stranded;
  if (left) {
    const node = left.node === "" ? t("goods.nowhere") : left.node;
    return left.handed_at ? t("calling.handed", { node: left.handed_at }) : t("calling.left", { atv: vehicleName(left.atv), node });
  }
  if (call.status === "waiting") {
    const { not_before: begin, vehicle, vehicle_waits: waits } = call;
    if (call.wait === "not_before" && begin !== null) return t("calling.begins", { at: format.due(Date.parse(begin) / 1000, moment.value.nowS) });
    if (vehicle !== null && waits !== null && call.wait !== "no_room" && call.wait !== "short")
      return t("calling.wait.vehicle", { vehicle, why: word("unwilling", waits) });
    if (call.wait !== "no_room" && call.wait !== "short" && call.wait !== "no_bid") return t("calling.wait.undecided");
    const at = format.due(Date.parse(call.updated_at) / 1000, moment.value.nowS);
    if (call.wait === "no_room") return t("calling.noRoom", { place: placeOf(call.to), at });
    return t("calling.waitsSince", { why: t(`calling.wait.${call.wait}`), at });
  }
  const at = call.expected_at === null ? "" : ` · ${t("card.there", { at: format.due(Date.parse(call.expected_at) / 1000, moment.value.nowS) })}`;
  return `${call.carrier ?? ""}${at}${call.status === "on_board" ? ` · ${t("calling.tooLate")}` : ""}`;
}
