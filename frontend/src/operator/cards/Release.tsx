import type { AtvView } from "../../api/types";
import { Icon } from "../../parts/Icon";
import { failureText } from "../../text/failure";
import { t } from "../../text/operator";
import { give } from "../commands/given";
import { hindranceOf } from "../../commands/hindrance";
import { circumstancesOf } from "../state";
import { HoldButton } from "./HoldButton";

/** The two acts that end a stop. They lie apart, so that one finger cannot do both at one place. */
export function Release({ atv }: { atv: AtvView }) {
  const around = circumstancesOf(atv);
  const toAcknowledge = hindranceOf("acknowledge", atv, around);
  const toResume = hindranceOf("resume", atv, around);
  return (
    <div class="release" role="group" aria-label={t("release.title", { atv: atv.id })}>
      <ol>
        <li>
          <button
            type="button"
            class="button act"
            disabled={toAcknowledge !== null}
            onClick={() => void give(atv.id, { kind: "acknowledge" })}
          >
            {atv.acknowledged && <Icon name="check" />}
            <span>{t(atv.acknowledged ? "release.acknowledged" : "release.acknowledge")}</span>
          </button>
        </li>
        <li>
          <HoldButton
            class="button act primary"
            disabled={toResume !== null}
            onHeld={() => void give(atv.id, { kind: "resume" })}
          >
            <span>{t("release.resume")}</span> <small>{t("release.hold")}</small>
          </HoldButton>
        </li>
      </ol>
      <p class="advice">{adviceOf(atv)}</p>
    </div>
  );
}

function adviceOf({ acknowledged, problem }: AtvView): string {
  if (problem !== "") return t("release.fault", { problem: failureText(problem) });
  return t(acknowledged ? "release.next" : "release.first");
}
