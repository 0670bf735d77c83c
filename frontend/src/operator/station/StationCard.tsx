import type { BufferView, MachineSpec, MachineView } from "../../api/types";
import { Documents } from "../../parts/Documents";
import { Later } from "../../parts/Later";
import { Meter } from "../../parts/Meter";
import { Tag, toneOfMachine } from "../../parts/Tag";
import { isLost } from "../../plant/silence";
import { filledFrac, isLow } from "../../plant/stock";
import { world } from "../../stream/stream";
import { vehicleName } from "../../text/elsewhere";
import { failureText } from "../../text/failure";
import { format, t, word } from "../../text/operator";
import { moment, names } from "../state";
import { shown } from "./shown";

const loadPieces = async () => (await import("../../parts/pieces/Pieces")).load();
const nameOf = (product: string): string => names.value(product);

/** What the station has of its material, and who brings more. */
export function StationCard() {
  const spec = shown.value;
  return (
    <section class="station card" aria-label={t("station.title")} tabIndex={0}>
      {spec ? <Station spec={spec} machine={world.value?.machines.get(spec.id)} /> : <p class="empty">{t("station.none")}</p>}
    </section>
  );
}

function Station({ machine, spec }: { machine: MachineView | undefined; spec: MachineSpec }) {
  const lost = machine !== undefined && isLost(machine, moment.value.nowS, moment.value.speed);
  return (
    <>
      <header>
        <h2>
          {spec.id} <span class="title-more">{spec.name}</span>
        </h2>
        {machine && (
          <Tag tone={lost ? "alarm" : toneOfMachine(machine.status)}>
            {lost ? t("machine.lost") : word("machine", machine.status)}
          </Tag>
        )}
      </header>
      {machine ? (
        <>
          {machine.problem !== "" && <p class="problem">{failureText(machine.problem)}</p>}
          <Goals machine={machine} />
          <Documents machine={machine} name={nameOf} />
          <ul class={`stock ${lost ? "old" : ""}`}>
            {[...machine.buffers, ...machine.goods].map((buffer) => (
              <StockRow key={buffer.item} buffer={buffer} machine={machine} />
            ))}
          </ul>
          <Later load={loadPieces} of={{ machine: spec.id, name: nameOf }} />
        </>
      ) : (
        <p class="empty">{t("station.unheard")}</p>
      )}
    </>
  );
}

/** What it makes: how far it is, and by when it should be done. */
function Goals({ machine }: { machine: MachineView }) {
  if (machine.goals.length === 0) return <p class="muted">{t("station.noGoal")}</p>;
  return (
    <ul class="goals">
      {machine.goals.map(({ deadline_at_s: atS, goal, made, order_due_at_s: orderS, product, quantity }) => (
        <li key={goal}>
          <span class="clip">{names.value(product)}</span>
          <Meter frac={quantity > 0 ? made / quantity : 0} label={t("station.goalLabel", { item: names.value(product), made, quantity })} />
          <span class="num">{t("machine.level", { level: format.count(made), capacity: format.count(quantity) })}</span>
          {atS !== null && <small>{t("station.due", { at: format.due(atS, moment.value.nowS) })}</small>}
          {orderS !== null && <small>{t("station.orderDue", { at: format.due(orderS, moment.value.nowS) })}</small>}
        </li>
      ))}
    </ul>
  );
}

function StockRow({ buffer, machine }: { buffer: BufferView; machine: MachineView }) {
  const { capacity, item, level, on_order: order, reorder_point: reorder } = buffer;
  // Only material has a reorder point; finished goods wait to be fetched.
  const low = reorder > 0 && isLow(buffer);
  const name = names.value(item);
  const label = t("machine.levelLabel", { item: name, level, capacity, reorder, order });
  return (
    <li>
      <span class="clip">{name}</span>
      <Meter
        frac={filledFrac(buffer)}
        behind={filledFrac({ level: level + order, capacity })}
        mark={reorder > 0 ? reorder / capacity : undefined}
        tone={low ? "warn" : "normal"}
        label={label}
      />
      <span class={`num ${low ? "tone-warn" : ""}`}>
        {t("machine.level", { level: format.count(level), capacity: format.count(capacity) })}
      </span>
      {order > 0 && <small>{comingText(machine, item, order)}</small>}
    </li>
  );
}

function comingText(machine: MachineView, item: string, order: number): string {
  const task = machine.tasks.find((each) => each.item === item);
  const quantity = format.count(order);
  if (!task || task.primary === "") return t("station.ordered", { quantity });
  const carrier = world.value?.atvs.get(task.primary);
  const at = carrier?.task?.due_at_s;
  const by = { quantity, atv: vehicleName(task.primary) };
  // Who is silent or stands still promises nothing any more.
  if (carrier && isLost(carrier, moment.value.nowS, moment.value.speed)) return t("station.comingSilent", by);
  if (carrier?.status === "stopped") return t("station.comingStopped", by);
  const coming = at ? t("station.coming", { ...by, at: format.due(at, moment.value.nowS) }) : t("station.comingBy", by);
  return task.secondary === "" ? coming : `${coming} · ${t("machine.secondary", { atv: vehicleName(task.secondary) })}`;
}
