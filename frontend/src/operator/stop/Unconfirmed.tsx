import { Link } from "../../parts/Link";
import { nowS, world } from "../../stream/stream";
import { format, t } from "../../text/operator";
import type { Command } from "../commands/life";
import { refusalText } from "../problem-text";
import { openStops, seeTo } from "./open";
import { isWorrying } from "./unconfirmed";

/** The Stops that nobody has confirmed: in sight until they are, or until a person says that it was seen to. */
export function Unconfirmed() {
  const worrying = [...openStops.value.values()].filter((command) => isWorrying(command, nowS.value));
  if (worrying.length === 0) return null;
  return (
    <ul class="worries" aria-label={t("worry.title")}>
      {worrying.map((command) => (
        <Worry key={command.id} command={command} />
      ))}
    </ul>
  );
}

function Worry({ command }: { command: Command }) {
  const near = world.value?.atvs.has(command.atv) ?? false;
  const stage = command.stage === "sent" || command.stage === "accepted" ? "not_confirmed" : command.stage;
  return (
    <li class="worry">
      <p role="alert">
        <b>
          {t("command.stop")} <Link kind="atv" id={command.atv} /> {t(`stage.${stage}`)}
        </b>{" "}
        <span class="num">{format.clock(command.atS)}</span>
        {!near && <span> · {t("stop.away")}</span>}
        <small>{refusalText(command) || t("worry.look")}</small>
      </p>
      <button
        type="button"
        class="button"
        onClick={() => {
          seeTo(command);
        }}
      >
        {t("worry.seen")} <span class="unseen">{command.atv}</span>
      </button>
    </li>
  );
}
