import type { TaskView } from "../../api/types";
import { Card } from "../../parts/Card";
import { Fact, Facts } from "../../parts/Facts";
import { Link } from "../../parts/Link";
import { Tag } from "../../parts/Tag";
import { world } from "../../stream/stream";
import { format, t } from "../../text/manager";
import { isOpen } from "../auction/auction";
import { names } from "../state";
import type { PlaceInfo } from "./place";

/** A storage, warehouse or charger: what it keeps, and who comes. */
export function PlaceCard({ place }: { place: PlaceInfo }) {
  const atvs = [...(world.value?.atvs.values() ?? [])].filter((atv) => atv.berth === place.id);
  const tasks = [...(world.value?.tasks.values() ?? [])].filter(isOpen);
  const charger = place.kind === "charger";
  return (
    <Card title={place.name} aside={<Tag>{t(`place.${place.kind}`)}</Tag>} class="place">
      <Facts>
        {charger ? (
          <Fact name={t("place.charging")}>
            {atvs.length === 0 ? t("place.free") : atvs.map((atv) => <Link key={atv.id} kind="atv" id={atv.id} />)}
          </Fact>
        ) : (
          <>
            <Transports name={t("place.fetching")} tasks={tasks.filter((task) => task.source === place.id)} />
            <Transports name={t("place.bringing")} tasks={tasks.filter((task) => task.destination === place.id)} />
          </>
        )}
      </Facts>
      {place.stocks.length > 0 && (
        <div class="stock">
          <h3>{t("place.keeps")}</h3>
          <Facts>
            {place.stocks.map(({ capacity, material }) => (
              <Fact key={material} name={names.value(material)}>
                {t("place.upTo", { quantity: format.count(capacity) })}
              </Fact>
            ))}
          </Facts>
        </div>
      )}
    </Card>
  );
}

/** More would push the vehicle's card away; the view Tasks has them all. */
const MOST = 4;

function Transports({ name, tasks }: { name: string; tasks: readonly TaskView[] }) {
  return (
    <Fact name={name}>
      {tasks.length === 0 ? t("factory.none") : tasks.slice(0, MOST).map(({ id }) => <Link key={id} kind="task" id={id} />)}
    </Fact>
  );
}
