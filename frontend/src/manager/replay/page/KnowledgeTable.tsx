import type { components } from "../../../api/types";
import { format, t } from "../../../text/views/replay";
import { loadOf, placeOf } from "../../orders/page/moments";
import { seek } from "./state";
import type { Knowledge } from "./api";

type Known = components["schemas"]["KnownView"];
type RecordedFact = components["schemas"]["RecordedFactView"];

const ROLES = { primary: "primary", secondary: "secondary", coordinator: "coordinator" } as const;
const KINDS = [
  "ContractTaken", "ContractEnded", "PhaseEntered", "TookOver", "CarrierChanged", "PrimarySuspected", "WatchLost", "TaskClosed",
] as const;

/** What it knew beside what had happened, and when it learnt of it; what differs comes first. */
export function KnowledgeTable({ knowledge }: { knowledge: Knowledge }) {
  const { agent, items } = knowledge;
  const latest = items.find((item) => item.differs && item.learnt_at_s !== null)?.learnt_at_s ?? null;
  return (
    <>
      <table class="knows">
        <thead>
          <tr>
            <th scope="col">{t("knows.knew", { agent })}</th>
            <th scope="col">{t("knows.happened")}</th>
            <th scope="col">{t("knows.learnt", { agent })}</th>
          </tr>
        </thead>
        <tbody>
          {items.map((item) => (
            <Row key={`${item.about}-${item.task}`} item={item} atS={knowledge.at_s} />
          ))}
        </tbody>
      </table>
      {items.length === 0 && <p class="empty">{t("knows.none")}</p>}
      {latest !== null && (
        <button type="button" class="link knows-go" onClick={() => { seek(latest); }}>
          {t("knows.learnt", { agent })}: {format.clock(latest)}
        </button>
      )}
    </>
  );
}

function Row({ atS, item }: { item: Known; atS: number }) {
  if (item.about !== "task") return <Plain item={item} atS={atS} />;
  const load = `${loadOf(item.item, 1)}, ${placeOf(item.source)} → ${placeOf(item.destination)}`;
  const role = item.role in ROLES ? (item.role as keyof typeof ROLES) : "";
  return (
    <tr class={item.differs ? "differs" : ""}>
      <td>
        <b>{t(`knows.role.${role}`, { load })}</b>
        <small class="line muted">{item.knew === null ? t("knows.nothing") : toldText(item.knew)}</small>
      </td>
      <td>
        <span aria-hidden="true">{item.differs ? "≠ " : "= "}</span>
        {item.happened === null ? t("knows.same") : toldText(item.happened)}
      </td>
      <td class="num">{learntText(item, atS)}</td>
    </tr>
  );
}

function Plain({ atS, item }: { item: Known; atS: number }) {
  const heardS = item.heard_at_s ?? atS;
  const text =
    item.about === "closures"
      ? t("knows.closures", { n: format.count(item.closures.length) })
      : item.differs
        ? t("knows.heardGap", { age: format.duration(atS - heardS) })
        : t("knows.heard", { at: format.clock(heardS) });
  return (
    <tr class={item.differs ? "differs" : ""}>
      <td colSpan={3}>{text}</td>
    </tr>
  );
}

function learntText(item: Known, atS: number): string {
  if (item.happened === null || !item.differs) return t("knows.knewIt");
  if (item.learnt_at_s === null) return t("knows.never");
  return `${format.clock(item.learnt_at_s)} · ${t("knows.later", { age: format.age(item.learnt_at_s - atS) })}`;
}

function toldText(told: RecordedFact): string {
  const kind = KINDS.find((each) => each === told.kind);
  if (kind === undefined) return format.clock(told.at_s);
  return t(`knows.${kind}`, { agent: told.agent, other: told.other, at: format.clock(told.at_s) });
}
