import type { Openings } from "../../parts/openings";
import { t } from "../../text/manager";

interface Props {
  readonly of: Pick<Openings<unknown>, "refused" | "drop">;
  /** The sheet with the form. */
  readonly form: string;
}

/** Beside a form: what was refused after the form was opened for something else. */
export function RefusedSince({ form, of }: Props) {
  return (
    <div role="alert" class="refusals-since">
      {of.refused.value.map((refused) => (
        <p key={refused.text} class="problem refused-since">
          <span>{refused.text}</span>
          <button
            type="button"
            class="button small"
            onClick={() => {
              document.getElementById(form)?.showPopover();
              refused.restore();
            }}
          >
            {t("refused.open")}
          </button>
          <button type="button" class="button small" onClick={() => { of.drop(refused); }}>
            {t("refused.drop")}
          </button>
        </p>
      ))}
    </div>
  );
}
