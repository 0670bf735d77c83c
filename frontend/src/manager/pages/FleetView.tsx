import { signal, useComputed } from "@preact/signals";
import type { AtvView } from "../../api/types";
import { batteryText } from "../../parts/battery";
import { Meter } from "../../parts/Meter";
import { Table } from "../../parts/Table";
import { Tag, toneOfAtv } from "../../parts/Tag";
import { isLost } from "../../plant/silence";
import { byId } from "../../plant/places";
import { nowS, presentS, world } from "../../stream/stream";
import { failureText } from "../../text/failure";
import { sinceHeardIn } from "../../text/heard";
import { format, t, word } from "../../text/manager";
import { inFactoryTime } from "../../text/plant-time";
import { ClockMark } from "../cards/agents/ClockMark";
import { updateText } from "../cards/agents/update-text";
import { doingText } from "../cards/atv/doing";
import { helpText } from "../cards/atv/help";
import { linkText } from "../cards/atv/link";
import { ShowLink } from "../parts/ShowLink";
import { CsvLink } from "../parts/filters/CsvLink";
import { holds } from "../parts/filters/match";
import { Search } from "../parts/filters/Search";
import { names } from "../state";

const words = signal("");

/** Every vehicle: what it does, its battery, and when it was heard last. */
export function FleetView() {
  const atvs = useComputed(() => [...(world.value?.atvs.values() ?? [])].sort(byId)).value;
  const shown = atvs.filter((atv) => holds(words.value, atv.id, atv.type, word("atv", atv.status), atv.task?.task ?? "", atv.software, atv.in_reserve ? t("atv.reserve") : ""));
  const heads = ["vehicle", "status", "task", "load", "battery", "link", "heartbeat", "software"] as const;
  return (
    <Table
      title={t("fleet.title")}
      heads={heads.map((head) => (head === "heartbeat" ? inFactoryTime(t("fleet.heartbeat")) : t(`fleet.${head}`)))}
      empty={t(atvs.length === 0 ? "factory.none" : "filter.none")}
      aside={
        <>
          <Search words={words} />
          <CsvLink href="/api/atvs?format=csv" />
        </>
      }
    >
      {shown.map((atv) => (
        <Row key={atv.id} atv={atv} />
      ))}
    </Table>
  );
}

function Row({ atv }: { atv: AtvView }) {
  const speed = world.value?.factory.speed ?? 1;
  const lost = isLost(atv, presentS.value, speed);
  const percent = batteryText(atv);
  const update = updateText(atv);
  return (
    <tr class={lost ? "silent" : ""}>
      <th scope="row">
        <ShowLink chosen={{ kind: "atv", id: atv.id }} label={t("fleet.show", { id: atv.id })} />
      </th>
      <td>
        <Tag tone={lost ? "alarm" : toneOfAtv(atv.status)}>{atv.shut_out ? t("atv.shut_out") : lost ? t("atv.lost") : word("atv", atv.status)}</Tag>{" "}
        <span class="muted">{atv.shut_out ? t("shutOut.by", { by: atv.shut_out.by, reason: atv.shut_out.reason }) : atv.problem !== "" ? failureText(atv.problem) : atv.task ? doingText(atv) : atv.in_reserve ? t("atv.reserve") : ""}</span>
        {atv.help && !atv.shut_out && <small class="line">{helpText(atv.help, nowS.value, speed)}</small>}
      </td>
      <td>{atv.task ? atv.task.task : ""}</td>
      <td>{atv.load && `${format.count(atv.load_quantity)} ${names.value(atv.load)}`}</td>
      <td>
        <span class="order-progress">
          <Meter frac={atv.battery_frac} label={percent} tone={atv.battery_frac < 0.2 ? "warn" : "normal"} />
          <span class="num">{percent}</span>
        </span>
      </td>
      <td>{lost ? t("atv.noLink") : atv.link === "mesh" ? <Tag tone="warn">{linkText(atv)}</Tag> : linkText(atv)}</td>
      <td class={`num ${lost ? "tone-alarm" : ""}`}>
        {t("machine.ago", { age: sinceHeardIn(nowS.value - atv.seen_at_s, speed) })} <ClockMark clock={atv.clock} />
      </td>
      <td class="muted">
        {atv.software} {update !== "" && <Tag>{update}</Tag>}
      </td>
    </tr>
  );
}
