import { useComputed } from "@preact/signals";
import { Card } from "../../../parts/Card";
import { presentS, world } from "../../../stream/stream";
import { Later } from "../../../parts/Later";
import { format, t } from "../../../text/manager";
import { inFactoryTime } from "../../../text/plant-time";
import { Term, type TermName } from "../../story/Term";
import { PauseMenu } from "../commands/PauseMenu";
import { LaneFaultMenu } from "../faults/FaultParts";
import { Sparkline } from "./Sparkline";
import { LOST, SHUT_OUT, statusCounts } from "./status";
import { StatusRow } from "./StatusRow";

const ATV_ORDER = ["working", "idle", "charging", "stopped", "error", LOST, SHUT_OUT];
const MACHINE_ORDER = ["producing", "idle", "resting", "starved", "blocked", "error", LOST, SHUT_OUT];

/** The factory as a whole: does it deliver, do machines wait, how long do transports take. */
export function FactoryCard() {
  const factory = useComputed(() => world.value?.factory ?? null).value;
  const counts = useComputed(() => {
    const { atvs, factory, machines } = world.value ?? {};
    const of = (views: typeof atvs | typeof machines) =>
      statusCounts(views?.values() ?? [], presentS.value, factory?.speed ?? 1);
    return { atvs: of(atvs), machines: of(machines) };
  }).value;
  const percent = (frac: number | null | undefined) =>
    frac == null ? t("factory.none") : format.percent(frac, 1);
  const seconds = (s: number | null | undefined) => (s == null ? t("factory.none") : format.duration(s));
  return (
    <Card title={inFactoryTime(t("factory.title"))} class="factory">
      <div class="kpis">
        <Kpi value={percent(factory?.on_time_frac)} name={t("factory.onTime")} />
        <Kpi value={percent(factory?.starved_frac)} name={t("factory.starved")} />
        <Kpi value={seconds(factory?.transport_p50_s)} name={t("factory.p50")} term="p50" />
        <Kpi value={seconds(factory?.transport_p95_s)} name={t("factory.p95")} term="p95" />
      </div>
      <Sparkline values={factory?.deliveries_per_hour ?? []} />
      {/* Above what grows: these buttons keep their places. */}
      <div class="card-foot">
        <PauseMenu />
        <LaneFaultMenu />
        <Later load={async () => (await import("../closures/CloseMenu")).CloseMenu} />
      </div>
      <StatusRow name={t("factory.atvs")} group="atv" counts={counts.atvs} order={ATV_ORDER} />
      <StatusRow
        name={t("factory.machines")}
        group="machine"
        counts={counts.machines}
        order={MACHINE_ORDER}
      />
      <Later load={async () => (await import("../duty/DutyRow")).load()} />
    </Card>
  );
}

function Kpi({ value, name, term }: { value: string; name: string; term?: TermName }) {
  return (
    <div class="kpi">
      <b>{value}</b>
      {term ? <Term name={term}>{name}</Term> : <span>{name}</span>}
    </div>
  );
}
