import type { StockView, TaskView } from "../../../api/types";
import { Card } from "../../../parts/Card";
import { Fact, Facts } from "../../../parts/Facts";
import { Link } from "../../../parts/Link";
import { Tag } from "../../../parts/Tag";
import { GATE } from "../../../plant/places";
import { isLost } from "../../../plant/silence";
import { nowS, presentS, world } from "../../../stream/stream";
import { failureText } from "../../../text/failure";
import { sinceHeard } from "../../../text/heard";
import { format, t } from "../../../text/manager";
import { ClockFact } from "../agents/ClockMark";
import { ShutOutNote } from "../agents/ShutOutNote";
import { isOpen } from "../auction/auction";
import { names } from "../../state";
import { CallHere } from "./CallHere";
import { Doubts } from "./Doubts";
import type { PlaceInfo } from "./place";

/** A storage, warehouse or charger: what it keeps, and who comes. */
export function PlaceCard({ place }: { place: PlaceInfo }) {
  const atvs = [...(world.value?.atvs.values() ?? [])].filter((atv) => atv.dwell_point === place.id);
  const tasks = [...(world.value?.tasks.values() ?? [])].filter(isOpen);
  const charger = place.kind === "charger";
  const keeps = place.stocks.length > 0;
  const agent = place.kind === "delivery" ? GATE : place.id;
  const beats = keeps || place.kind === "delivery";
  const station = beats ? world.value?.stations.get(agent) : undefined;
  const lost = station !== undefined && isLost(station, presentS.value, world.value?.factory.speed ?? 1);
  return (
    <Card
      title={place.name}
      aside={lost ? <Tag tone="alarm">{t(station.shut_out ? "machine.shut_out" : "machine.lost")}</Tag> : <Tag>{t(`place.${place.kind}`)}</Tag>}
      class={`place ${lost ? "silent" : ""}`}
      scrolls
      foot={place.kind === "storage" ? <CallHere key={place.id} place={place.id} /> : undefined}
    >
      {station?.problem && !station.shut_out && <p class="problem">{failureText(station.problem)}</p>}
      {station?.shut_out && <ShutOutNote agent={agent} kind="machine" out={station.shut_out} />}
      <Facts>
        {beats && (
          <>
            <Fact name={t("machine.heartbeat")}>
              <span class={lost ? "tone-alarm" : ""}>
                {station ? t("machine.ago", { age: sinceHeard(nowS.value - station.seen_at_s) }) : t("machine.never")}
              </span>
            </Fact>
            <ClockFact clock={station?.clock} />
          </>
        )}
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
      <Doubts agent={agent} station doubts={station?.doubts ?? []} />
      {keeps && (
        <div class="stock">
          <h3>{t("place.keeps")}</h3>
          <Facts>
            {place.stocks.map(({ capacity, material }) => (
              <Fact key={material} name={names.value(material)}>
                <Kept stock={station?.stocks.find((stock) => stock.item === material)} capacity={capacity} />
              </Fact>
            ))}
          </Facts>
        </div>
      )}
    </Card>
  );
}

/** What lies there, as the station has told, and who waits for more; without a word of it, what finds room there. */
function Kept({ stock, capacity }: { stock: StockView | undefined; capacity: number }) {
  if (!stock) return <>{t("place.upTo", { quantity: format.count(capacity) })}</>;
  return (
    <>
      {stock.uncounted ? (
        <span class="tone-warn">{t("place.uncounted", { level: format.count(stock.level), capacity: format.count(stock.capacity) })}</span>
      ) : (
        t("place.stock", { level: format.count(stock.level), capacity: format.count(stock.capacity) })
      )}
      {stock.promised > 0 && <small>{t("place.promised", { quantity: format.count(stock.promised) })}</small>}
      {stock.on_order > 0 && <small>{t("place.onOrder", { quantity: format.count(stock.on_order) })}</small>}
      {stock.wanted > 0 && <small class="tone-warn">{t("place.wanted", { quantity: format.count(stock.wanted) })}</small>}
    </>
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
