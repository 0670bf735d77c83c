import { useSignal } from "@preact/signals";
import { afterSent } from "../../parts/sent";
import { t } from "../../text/operator";
import { plant } from "../state";
import { busy, place as here, sendThing } from "./call";
import { abilitiesOf } from "./steps";

/** As long as the gateway lets it be. */
const LONGEST = 100;

/** What has no master data: what it is, where to or where from, what it is carried as. The button sends it. */
export function ThingForm() {
  const thing = useSignal("");
  const place = useSignal("");
  const carried = useSignal("");
  const own = here.value?.id ?? "";
  const places = [...(plant.value?.storages ?? []), ...(plant.value?.machines ?? [])].filter(({ id }) => id !== own);
  const kinds = abilitiesOf(plant.value?.vehicle_types ?? []);
  const ability = carried.value || (kinds[0] ?? "");
  const isWhole = thing.value.trim() !== "" && place.value !== "" && ability !== "";
  const send = (way: "bring" | "take"): void => {
    const sent = thing.value;
    void sendThing(way, sent.trim(), place.value, ability).then((called) => {
      if (called) thing.value = afterSent(sent, thing.value, "");
    });
  };
  return (
    <details class="call-thing">
      <summary>{t("calling.thing")}</summary>
      <div class="call-thing-parts">
        <label>
          {t("calling.thingWhat")}
          <input autoComplete="off" maxLength={LONGEST} value={thing.value} onInput={(event) => { thing.value = event.currentTarget.value; }} />
        </label>
        <label>
          {t("calling.thingPlace")}
          <select value={place.value} onChange={(event) => { place.value = event.currentTarget.value; }}>
            <option value="">{t("calling.thingChoose")}</option>
            {places.map(({ id, name }) => <option key={id} value={id}>{name === id ? id : `${id} · ${name}`}</option>)}
          </select>
        </label>
        <label>
          {t("calling.thingCarried")}
          <select value={ability} onChange={(event) => { carried.value = event.currentTarget.value; }}>
            {kinds.map((kind) => <option key={kind} value={kind}>{kind}</option>)}
          </select>
        </label>
      </div>
      <div class="call-amounts">
        <button type="button" class="button act" disabled={busy.value || !isWhole} onClick={() => { send("bring"); }}>{t("calling.thingBring", { place: own })}</button>
        <button type="button" class="button act" disabled={busy.value || !isWhole} onClick={() => { send("take"); }}>{t("calling.thingTake", { place: own })}</button>
      </div>
    </details>
  );
}
