import type { AtvView, HelpView, ProblemView } from "../../api/types";
import { failureText } from "../../text/failure";
import { t, word } from "../../text/operator";
import { factoryTime, inFactoryTime } from "../../text/plant-time";
import { give } from "../commands/given";
import { answer, callOf, hasCallCard } from "../duty/duty";
import { hindranceOf } from "../../commands/hindrance";
import { circumstancesOf, moment } from "../state";
import { HandOver } from "./HandOver";
import { patienceS } from "./need";

/** How long it takes to walk over and put something right; what is more than the vehicle waits for is not offered. */
const MINUTES = [1, 3, 5, 10];

/** What has happened to a vehicle, how long its task waits, and the promise to come. */
export function HelpAsk({ atv }: { atv: AtvView }) {
  const leftS = patienceS(atv, moment.value);
  return (
    <div class="help">
      {atv.problem !== "" && <p class="help-what">{t("help.what", { problem: failureText(atv.problem) })}</p>}
      {atv.about_problem && <p class="help-known">{knownText(atv.about_problem)}</p>}
      {atv.help === null || leftS === null ? (
        <p>{t("help.noTask")}</p>
      ) : leftS <= 0 ? (
        <>
          <p>{t("help.over")}</p>
          <Promises atv={atv} />
        </>
      ) : (
        <>
          <Patience help={atv.help} leftS={leftS} />
          <Promises atv={atv} />
          <HandOver atv={atv} />
        </>
      )}
    </div>
  );
}

/** Promises to come. Of somebody on duty that takes the call, too, and nobody else is asked any more; the gateway then promises it to the one that calls. */
export function promise(agent: string, waitS: number, give: () => Promise<void>): void {
  const call = callOf(agent);
  void (call ? answer(call, { answer: "take", wait_s: waitS }) : give());
}

/** What the vehicle knows of its problem: its kind, and what helps. */
export function knownText({ kind, load_movable: movable, needs_person: needed, passes }: ProblemView): string {
  const said = [word("help.kind", kind)];
  if (passes !== null) said.push(t(passes ? "help.passes" : "help.stays"));
  if (needed) said.push(t("help.person"));
  if (movable !== null) said.push(t(movable ? "help.movable" : "help.fixed"));
  return said.join(" ");
}

interface PatienceProps {
  readonly help: HelpView;
  readonly leftS: number;
  readonly waits?: string;
  readonly coming?: "help.coming" | "machine.coming";
}

export function Patience({ coming = "help.coming", help, leftS, waits = t("help.waits") }: PatienceProps) {
  const by = help.promised_by;
  return (
    <p class="patience" role="timer">
      <b class="countdown">{factoryTime(leftS)}</b>
      <span>{by === "" ? waits : t(coming, { by })}</span>
    </p>
  );
}

function Promises({ atv }: { atv: AtvView }) {
  if (hasCallCard(atv.id)) return null;
  const disabled = hindranceOf("promise", atv, circumstancesOf(atv)) !== null;
  const promised = atv.help?.promised_by !== "";
  const longestS = atv.help?.promise_max_s ?? 0;
  const title = inFactoryTime(t(promised ? "help.later" : "help.onMyWay"));
  return (
    <div class="promises" role="group" aria-label={title}>
      <span aria-hidden="true">{title}</span>
      {MINUTES.filter((minutes) => minutes * 60 <= longestS).map((minutes) => (
        <button
          key={minutes}
          type="button"
          class={`button ${promised ? "" : "primary"}`}
          disabled={disabled}
          onClick={() => {
            promise(atv.id, minutes * 60, () => give(atv.id, { kind: "promise", wait_s: minutes * 60 }));
          }}
        >
          <span class="unseen">{t("help.there", { atv: atv.id })}</span> {t("help.in", { minutes })}
        </button>
      ))}
    </div>
  );
}
