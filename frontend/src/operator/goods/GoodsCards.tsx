import { useEffect } from "preact/hooks";
import type { TaskView } from "../../api/types";
import { world } from "../../stream/stream";
import { THING } from "../../plant/names";
import { vehicleName } from "../../text/elsewhere";
import { format, t } from "../../text/operator";
import { giveMachine, giveStation } from "../commands/given";
import { HoldButton } from "../cards/HoldButton";
import { moment, names, plant } from "../state";
import { isMute, LoadCard } from "./LoadCard";
import { strandedOf } from "./stranded";

/** Goods on board of failed vehicles: somebody hands them over, or writes them off; that is held, for nothing takes it back. */
export function GoodsCards() {
  const tasks = strandedOf(world.value?.tasks.values() ?? []);
  if (tasks.length === 0) return null;
  return (
    <ul class="cards needing" aria-label={t("goods.label")}>
      {tasks.map((task) => (
        <GoodsCard key={task.id} task={task} />
      ))}
    </ul>
  );
}

function GoodsCard({ task }: { task: TaskView }) {
  const { coordinator, id, stranded } = task;
  useEffect(() => {
    // The address of an alert leads here; the card comes after its page.
    if (location.hash === `#goods-${encodeURIComponent(id)}`) document.getElementById(`goods-${id}`)?.scrollIntoView({ block: "nearest" });
  }, [id]);
  if (stranded === null) return null;
  const isThing = task.item === THING;
  const say = (kind: "fetch_goods" | "write_off"): void => {
    const toStation = plant.value?.machines.every((machine) => machine.id !== coordinator) ?? false;
    void (toStation ? giveStation : giveMachine)(coordinator, { kind, task: id });
  };
  const disabled = isMute();
  const said = stranded.handed_at;
  const until = format.due(stranded.until_at_s, moment.value.nowS);
  return (
    <LoadCard
      id={`goods-${id}`}
      title={t(isThing ? "goods.titleThing" : "goods.title", { atv: vehicleName(stranded.atv) })}
      tag={id}
      what={goodsText(task)}
      look={said === "" ? t(isThing ? "goods.waitsThing" : "goods.waits", { at: until }) : t("goods.fetched", { node: said })}
      asker={coordinator}
    >
      {said === "" && (
        <button
          type="button"
          class="button fault-gone primary"
          disabled={disabled}
          onClick={() => { say("fetch_goods"); }}
        >
          <b>{t("command.fetch_goods")}</b>
          <small>{t("goods.more.fetch_goods")}</small>
        </button>
      )}
      <HoldButton
        class="button fault-gone"
        disabled={disabled}
        onHeld={() => { say("write_off"); }}
      >
        <b>{t("command.write_off")}</b>
        <small>{t(isThing ? "goods.more.writeOffThing" : "goods.more.write_off")}</small>
      </HoldButton>
    </LoadCard>
  );
}

/** What is on board, whose it is, for which order and where. */
export function goodsText({ coordinator: machine, item, quantity, stranded }: TaskView): string {
  const order = stranded?.order_name ?? "";
  const node = stranded?.node ?? "";
  const said = { quantity: format.count(quantity), item: names.value(item), machine, order, node: node === "" ? t("goods.nowhere") : node };
  if (item === THING) return t("goods.whatThing", said);
  return t(order === "" ? "goods.what" : "goods.whatFor", said);
}
