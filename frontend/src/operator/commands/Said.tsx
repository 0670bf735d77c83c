import { t } from "../../text/operator";
import { lastSaid } from "./given";
import { whatText } from "./CommandLine";

/** Reads out what has become of the last command, for who does not look at the screen. */
export function Said() {
  const command = lastSaid.value;
  return (
    <p class="unseen" role="status">
      {command && t("command.said", { atv: command.atv, what: whatText(command), stage: t(`stage.${command.stage}`) })}
    </p>
  );
}
