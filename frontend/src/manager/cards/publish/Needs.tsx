import type { MachineOffer, MaterialNeed, OrderPreview } from "../../../api/types";
import { format, t, word } from "../../../text/manager";
import { inFactoryTime } from "../../../text/plant-time";
import { Sheet } from "../../parts/Sheet";
import { names } from "../../state";

const ID = "publish-needs";

/** Opens the tables behind the lines of the card. */
export function NeedsButton() {
  return (
    <button type="button" class="link needs-button" popovertarget={ID}>
      {t("needs.open")}
    </button>
  );
}

/** What the order would need, in full: machines and their queues, material against stock and demand. */
export function Needs({ found }: { found: OrderPreview }) {
  return (
    <Sheet id={ID} title={t("needs.title")}>
      <h3>{t("needs.machines")}</h3>
      <table>
        <thead>
          <tr>
            <th scope="col">{t("needs.machine")}</th>
            <th scope="col">{t("needs.status")}</th>
            <th scope="col">{inFactoryTime(t("needs.queue"))}</th>
            <th scope="col">{t("needs.share")}</th>
          </tr>
        </thead>
        <tbody>
          {found.machines.map((offer) => (
            <Offer key={offer.machine} offer={offer} />
          ))}
        </tbody>
      </table>
      <h3>{t("needs.materials")}</h3>
      <table>
        <thead>
          <tr>
            <th scope="col">{t("needs.material")}</th>
            <th scope="col">{t("needs.needed")}</th>
            <th scope="col">{t("needs.wanted")}</th>
            <th scope="col">{t("needs.atMachines")}</th>
            <th scope="col">{t("needs.storages")}</th>
          </tr>
        </thead>
        <tbody>
          {found.materials.map((need) => (
            <Material key={need.material} need={need} />
          ))}
        </tbody>
      </table>
      <p class="faint">{t("needs.hint")}</p>
    </Sheet>
  );
}

function Offer({ offer }: { offer: MachineOffer }) {
  return (
    <tr>
      <th scope="row">{offer.machine}</th>
      <td class={offer.available ? "" : "tone-warn"}>{word("machine", offer.status === "silent" ? "lost" : offer.status)}</td>
      <td class="num">{offer.queue_s < 1 ? t("needs.free") : format.duration(offer.queue_s)}</td>
      <td class="num">{format.count(offer.pieces)}</td>
    </tr>
  );
}

function Material({ need }: { need: MaterialNeed }) {
  const storages = need.storages.map(({ capacity, storage }) =>
    t("needs.storage", { storage, capacity: format.count(capacity) }),
  );
  return (
    <tr>
      <th scope="row">{names.value(need.material)}</th>
      <td class="num">{format.count(need.needed)}</td>
      <td class="num">{format.count(need.wanted)}</td>
      <td class="num">{format.count(need.at_machines)}</td>
      <td>
        {format.list(storages)}
        {need.refills && <small class="line tone-warn">{t("needs.refills")}</small>}
      </td>
    </tr>
  );
}
