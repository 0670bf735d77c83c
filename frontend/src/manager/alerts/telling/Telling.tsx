import { speakAlso } from "../../../text/speech";
import { t, tables } from "../../../text/views/alerts";
import { refusal, wanted, want, type Way } from "./telling";

/** The choice, once it has its words. */
export async function load(): Promise<typeof Telling> {
  await speakAlso(tables);
  return Telling;
}

/** Whether this browser tells of new alarms, and how; it says plainly when it is not allowed to. */
export function Telling() {
  return (
    <fieldset class="telling">
      <legend>{t("telling.label")}</legend>
      <Choice way="sound" />
      <Choice way="notice" />
      <small class="muted line">{t("telling.here")}</small>
    </fieldset>
  );
}

function Choice({ way }: { way: Way }) {
  const why = refusal[way].value;
  return (
    <>
      <label class="only">
        <input
          type="checkbox"
          checked={wanted[way].value}
          onChange={(event) => {
            const box = event.currentTarget;
            void want(way, box.checked).then(() => { box.checked = wanted[way].value; });
          }}
        />
        <span>{t(`telling.${way}`)}</span>
      </label>
      {why !== "" && <small class="line tone-warn" role="status">{t(`telling.${why}`)}</small>}
    </>
  );
}
