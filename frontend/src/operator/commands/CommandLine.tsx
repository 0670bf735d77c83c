import { format, t } from "../../text/operator";
import { nowS, world } from "../../stream/stream";
import { refusalText } from "../problem-text";
import { lastOf } from "./given";
import { type Command, isUnderway, stagesOf } from "./life";

/** A word that was said so long ago tells nothing about now. */
const SHOWN_S = 90;

/** How far the last command to a vehicle or a machine has come. */
export function CommandLine({ atv, stopped }: { atv: string; stopped: boolean }) {
  const command = lastOf(atv);
  if (!command || (!stopped && !isUnderway(command) && nowS.value - command.atS > SHOWN_S)) return null;
  const stages = stagesOf(command);
  return (
    <p class={`command command-${command.stage}`}>
      <b>{whatText(command)}</b>
      {stages.map((stage, i) => (
        <span key={stage} class={i === stages.length - 1 ? "stage now" : "stage"}>
          {t(stage === "confirmed" && world.value?.machines.has(atv) ? "stage.confirmedMachine" : `stage.${stage}`)}
        </span>
      ))}
      {!isUnderway(command) && <time>{format.clock(command.atS)}</time>}
      {command.by !== "" && <span class="faint">{t("command.by", { by: command.by })}</span>}
      {refusalText(command) !== "" && <span class="command-why">{refusalText(command)}</span>}
    </p>
  );
}

export function whatText({ kind, speedFrac }: Pick<Command, "kind" | "speedFrac">): string {
  return kind === "set_speed"
    ? t("command.set_speed", { percent: format.percent(speedFrac ?? 1) })
    : t(`command.${kind}`);
}
