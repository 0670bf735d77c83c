import type { CallView } from "../../api/types";
import { Tag } from "../../parts/Tag";
import { failureText } from "../../text/failure";
import { format, t, word } from "../../text/operator";
import { moment } from "../state";
import { answer, duty } from "./duty";

/** How long it takes to walk over and put something right. */
const MINUTES = [2, 5, 10];

/** Calls for help that ask this person, or that this person has taken. */
export function CallCards() {
  const calls = duty.value?.calls.filter(({ part }) => part !== null) ?? [];
  return (
    <div class="calls-live" aria-live="assertive">
      {calls.length > 0 && (
        <ul class="cards calls" aria-label={t("call.title")}>
          {calls.map((call) => (
            <CallCard key={call.id} call={call} />
          ))}
        </ul>
      )}
    </div>
  );
}

function CallCard({ call }: { call: CallView }) {
  const { nowS, speed } = moment.value;
  const leftS = Math.max(0, ((call.until_at_s ?? nowS) - nowS) * speed);
  const mine = call.part === "taken";
  const others = call.asked.filter((code) => code !== duty.value?.code);
  return (
    <li class="card call">
      <header>
        <h2>{call.caller}</h2>
        <Tag tone="warn">{t(mine ? "call.expected" : "call.asks")}</Tag>
        <span class="call-left">
          <b>{format.duration(leftS)}</b> {t(mine ? "call.promised" : "call.toAnswer")}
        </span>
      </header>
      <p>
        {call.reason !== "" && <b>{failureText(call.reason)}. </b>}
        {word("help.kind", call.problem)}
      </p>
      {!mine && <p class="muted">{others.length === 0 ? t("call.alone") : t("call.others", { count: format.count(others.length) })}</p>}
      <div class="call-answers" role="group" aria-label={t("call.take", { caller: call.caller })}>
        {MINUTES.map((minutes) => (
          <button
            key={minutes}
            type="button"
            class={`button ${mine ? "" : "primary"}`}
            disabled={call.part === "taking"}
            onClick={() => void answer(call, { answer: "take", wait_s: minutes * 60 })}
          >
            <b>{t(mine ? "call.later" : "call.iTake")}</b> {t("call.within", { minutes })}
          </button>
        ))}
        <button type="button" class="button" onClick={() => void answer(call, { answer: "decline" })}>
          {t(mine ? "call.giveBack" : "call.pass")}
        </button>
        <button type="button" class="button" onClick={() => void answer(call, { answer: "cannot" })}>
          {t("call.cannot")}
        </button>
      </div>
      {!mine && <p class="muted">{t("call.notAssigned")}</p>}
    </li>
  );
}
