import { useSignal } from "@preact/signals";
import { useId } from "preact/hooks";
import { carryAway, putBack } from "../api/client";
import type { AtvView, PlantFile } from "../api/types";
import { freePlaces } from "../plant/free-places";
import { refusalsOf } from "../plant/removal-refusals";
import { isLost } from "../plant/silence";
import { isPast } from "../stream/freshness";
import { freshness } from "../stream/stream";
import { format, t } from "../text";
import { factoryTime } from "../text/plant-time";

interface Props {
  atv: AtvView;
  atvs: Iterable<AtvView>;
  /** Whether its body is simulated. */
  isSimulated: boolean;
  plant: PlantFile | null;
  nowS: number;
  speed: number;
  problemText: (error: unknown) => string;
}

/** With right of way a silent vehicle keeps its places: the steps by which people carry it away, and put it back. */
export function Carrying(props: Props) {
  const { atv, nowS, problemText, speed } = props;
  const busy = useSignal(false);
  const failed = useSignal("");
  if (atv.shut_out || !isLost(atv, nowS, speed) || (!atv.removal && atv.holds.length === 0)) return null;
  const act = (doing: Promise<void>): void => {
    busy.value = true;
    failed.value = "";
    void doing
      .catch((error: unknown) => {
        failed.value = t("carry.failed", { reason: problemText(error) });
      })
      .finally(() => {
        busy.value = false;
      });
  };
  return (
    <div class="carrying">
      {atv.removal ? <Back {...props} act={act} busy={busy.value} /> : <Away {...props} act={act} busy={busy.value} />}
      {failed.value !== "" && <p role="alert">{failed.value}</p>}
    </div>
  );
}

/** What is seen is old, and what is said now reaches nobody: the vehicle may have come back meanwhile. */
export function isCutOff(): boolean {
  return isPast(freshness.value) || freshness.value === "connecting";
}

/** Why it cannot be said now: once for all vehicles of one list. */
export function CutOff({ class: name = "muted" }: { class?: string }) {
  return isCutOff() ? <p class={name} role="status">{t("carry.cutOff")}</p> : null;
}

/** A person of the simulation has put it down; what somebody has switched off as a fault stays off. */
function keptText(kept: boolean, isSimulated: boolean): "carry.kept" | "carry.stands" | "carry.waits" {
  if (!kept) return "carry.waits";
  return isSimulated ? "carry.stands" : "carry.kept";
}

/** Factory seconds from when all machines should free its places, until people are told that one may refuse, though none has said so. */
const FREED_WITHIN_S = 60;

/** Whether a machine seems to refuse the report, and its answer is not known here. */
function isRefused({ holds, removal }: AtvView, leftS: number): boolean {
  return removal?.freed.length === 0 && holds.length > 0 && leftS < -FREED_WITHIN_S;
}

/** Who refuses the report, and why. */
function Refused({ atv, leftS }: { atv: AtvView; leftS: number }) {
  const refusals = [...refusalsOf(atv)];
  if (refusals.length === 0) return isRefused(atv, leftS) ? <p role="alert">{t("carry.notFree")}</p> : null;
  return (
    <div role="alert">
      {refusals.map(([reason, agents]) => (
        <p key={reason}>
          {t("carry.refused", {
            agents: format.list(agents.map((agent) => (agent === "" ? t("carry.elsewhere") : agent))),
            reason: t(`carry.refused.${reason}`),
          })}
        </p>
      ))}
    </div>
  );
}

interface Acting extends Props {
  act: (doing: Promise<void>) => void;
  busy: boolean;
}

function Away({ act, atv, busy, nowS }: Acting) {
  const sure = useSignal(false);
  return (
    <details>
      <summary>{t("carry.open", { atv: atv.id })}</summary>
      <ol>
        <li>{t("carry.first", { node: atv.node, age: format.age(nowS - atv.seen_at_s) })}</li>
        <li>{t("carry.second")}</li>
        <li>{t("carry.third")}</li>
      </ol>
      <label>
        <input
          type="checkbox"
          checked={sure.value}
          onInput={(event) => {
            sure.value = event.currentTarget.checked;
          }}
        />{" "}
        {t("carry.sure", { atv: atv.id })}
      </label>
      <button
        type="button"
        class="button primary"
        disabled={busy || !sure.value || isCutOff()}
        onClick={() => {
          act(carryAway(atv.id));
        }}
      >
        {t("carry.do")}
      </button>
      <CutOff />
    </details>
  );
}

function Back({ act, atv, atvs, busy, isSimulated, nowS, plant, speed }: Acting) {
  const chosen = useSignal("");
  const id = useId();
  const away = atv.removal;
  if (!away) return null;
  const leftS = away.believed_at_s - nowS;
  const places = freePlaces(plant, atvs, atv);
  const place = chosen.value === "" ? (places[0] ?? "") : chosen.value;
  return (
    <>
      <p>
        {t("carry.said", { by: away.by })}{" "}
        {away.freed.length > 0
          ? t("carry.freed", { places: format.list(away.freed) })
          : leftS > 0 && t("carry.soon", { time: factoryTime(leftS * speed, speed) })}
      </p>
      <Refused atv={atv} leftS={leftS * speed} />
      {away.node !== "" && <p role="status">{t(keptText(away.kept, isSimulated), { node: away.node })}</p>}
      <label for={id}>{t("carry.where")}</label>
      <div class="put-back">
        <select
          id={id}
          value={place}
          onChange={(event) => {
            chosen.value = event.currentTarget.value;
          }}
        >
          {places.map((each) => (
            <option key={each}>{each}</option>
          ))}
        </select>
        <button
          type="button"
          class="button"
          disabled={busy || place === "" || isCutOff()}
          onClick={() => {
            act(putBack(atv.id, place));
          }}
        >
          {t("carry.keep")}
        </button>
      </div>
      <CutOff />
    </>
  );
}
