import type { ComponentChildren } from "preact";
import { columnsOf } from "../../../../parts/stacked";
import { factorySeconds, inFactoryTime } from "../../../../text/plant-time";
import { format, t, word } from "../../../../text/views/shift";
import { MomentLink } from "../../../replay/MomentLink";
import { addressOf } from "../../../views";
import { type Agent, type Report, STATE_NAMES, statesOf } from "./shifts";
import { valueText } from "./value";

interface Props {
  title: string;
  heads: readonly string[];
  children: ComponentChildren;
  empty: boolean;
}

/** One of the lists: a heading, and rows below it, or that there are none. */
function List({ children, empty, heads, title }: Props) {
  return (
    <section class="shift-list">
      <h2>{title}</h2>
      {empty ? (
        <p class="muted">{t("shift.none")}</p>
      ) : (
        <div class="shift-scroll" tabIndex={0} role="group" aria-label={title}>
          <table class="stacked" style={columnsOf(heads)}>
            <thead>
              <tr>
                {heads.map((head) => (
                  <th key={head} scope="col">{head}</th>
                ))}
              </tr>
            </thead>
            <tbody>{children}</tbody>
          </table>
        </div>
      )}
    </section>
  );
}

/** Vehicles and machines, each with its states; and what happened in areas. */
export function DrillDown({ report }: { report: Report }) {
  return (
    <>
      <Agents title={t("shift.vehicles")} agents={report.agents.filter((each) => each.kind === "atv")} />
      <Agents title={t("shift.machines")} agents={report.agents.filter((each) => each.kind === "machine")} />
      <List title={t("shift.areas")} empty={report.areas.length === 0} heads={[t("shift.agent"), t("shift.starved"), t("shift.passes"), t("shift.waits"), inFactoryTime(t("shift.stood"))]}>
        {report.areas.map((area) => (
          <tr key={area.area}>
            <th scope="row">{area.name}</th>
            <td class="num">{valueText("frac", area.starved_frac)}</td>
            <td class="num">{format.count(area.passes)}</td>
            <td class="num">{format.count(area.waits)}</td>
            <td class="num">{format.duration(area.waited_s)}</td>
          </tr>
        ))}
      </List>
    </>
  );
}

function Agents({ agents, title }: { agents: readonly Agent[]; title: string }) {
  const shown = [...agents].sort((a, b) => a.agent.localeCompare(b.agent, undefined, { numeric: true }));
  const isAtv = shown[0]?.kind === "atv";
  const heads = [t("shift.agent"), t("shift.states"), ...STATE_NAMES.map((state) => word("shift.state", state)), ...(isAtv ? [t("shift.waits")] : [])];
  return (
    <List title={title} empty={shown.length === 0} heads={heads}>
      {shown.map((agent) => {
        const states = statesOf(agent);
        const told = Object.entries(agent.doings_s).map(([doing, spentS]) => `${word("doing", doing)} ${format.duration(spentS)}`);
        return (
          <tr key={agent.agent}>
            <th scope="row">{agent.agent}</th>
            <td>
              <span class="shift-states" role="img" aria-label={format.list(told)} title={format.list(told)}>
                {STATE_NAMES.map((state) => (
                  <i key={state} class={`state-${state}`} style={{ width: `${states[state] * 100}%` }} />
                ))}
              </span>
            </td>
            {STATE_NAMES.map((state) => (
              <td key={state} class="num">{format.percent(states[state], 1)}</td>
            ))}
            {isAtv && <td class="num">{format.count(agent.waits)}</td>}
          </tr>
        );
      })}
    </List>
  );
}

/** What happened: takeovers, what people did, the longest waits, late orders. */
export function Happened({ report }: { report: Report }) {
  return (
    <>
      <List title={t("shift.takeovers")} empty={report.takeovers.length === 0} heads={[t("shift.at"), t("shift.task"), t("shift.fromTo"), t("shift.cause")]}>
        {report.takeovers.map((each) => (
          <tr key={`${each.at_s} ${each.task}`}>
            <td class="num">
              {format.clock(each.at_s)} <MomentLink about={each.task} atS={each.at_s} />
            </td>
            <td>{each.task}</td>
            <td>{each.replaced} → {each.carrier}</td>
            <td>{word("reason.why", each.reason)}</td>
          </tr>
        ))}
      </List>
      <List title={t("shift.interventions")} empty={report.interventions.length === 0} heads={[t("shift.at"), t("shift.what"), t("shift.who"), t("shift.where")]}>
        {report.interventions.map((each, i) => (
          <tr key={i}>
            <td class="num">{format.clock(each.at_s)}</td>
            <td>
              {word("audit.did", each.action)}
              {each.command !== "" && ` (${word("shift.command", each.command)})`}
            </td>
            <td>{word("shift.role", each.role)}</td>
            <td>{each.target}</td>
          </tr>
        ))}
      </List>
      <List title={t("shift.worst")} empty={report.waits.length === 0} heads={[t("shift.at"), inFactoryTime(t("shift.waited")), t("shift.agent"), t("shift.for")]}>
        {report.waits.map((each) => (
          <tr key={`${each.agent} ${each.from_at_s}`}>
            <td class="num">
              {format.clock(each.from_at_s)} <MomentLink about={each.agent} atS={each.from_at_s} />
            </td>
            <td class="num">{format.duration(factorySeconds(each.until_at_s - each.from_at_s))}</td>
            <td>{each.agent}</td>
            <td>{each.other}</td>
          </tr>
        ))}
      </List>
      <List title={t("shift.late")} empty={report.late_orders.length === 0} heads={[t("shift.order"), t("shift.due"), t("shift.lateBy")]}>
        {report.late_orders.map((each) => (
          <tr key={each.id}>
            <td>
              <a class="link" href={addressOf(each.id)}>{each.reference ?? each.id}</a>
            </td>
            <td class="num">{format.moment(each.due_at_s)}</td>
            <td class="num">
              {format.duration((each.delivered_at_s ?? report.period.until_at_s) - each.due_at_s)}
              {each.delivered_at_s === null && `, ${t("shift.stillOpen")}`}
            </td>
          </tr>
        ))}
      </List>
    </>
  );
}
