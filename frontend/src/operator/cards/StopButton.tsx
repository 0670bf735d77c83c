import { t } from "../../text/operator";
import { give } from "../commands/given";

interface Props {
  atv: string;
  /** Beside others of its kind it has to say whom it stops. */
  named?: boolean;
}

/**
 * Stops a vehicle with one touch. Always there and always the same: it is never disabled, never hidden
 * behind anything, and a touch on it never scrolls.
 */
export function StopButton({ atv, named = false }: Props) {
  return (
    <button
      type="button"
      class="stop"
      aria-describedby="stop-not"
      onClick={() => void give(atv, { kind: "stop" })}
    >
      {named ? (
        <>
          <small>{t("command.stop")}</small>{" "}
          <span>{atv}</span>
        </>
      ) : (
        <span>
          {t("stop.label")} <span class="unseen">{atv}</span>
        </span>
      )}
    </button>
  );
}
