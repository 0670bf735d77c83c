import { fetchPeople, type Person } from "../../../api/people";
import { Table } from "../../../parts/Table";
import { Tag } from "../../../parts/Tag";
import { speakAlso } from "../../../text/speech";
import { format, t, tables, word } from "../../../text/views/people";
import { tables as records } from "../../../text/views/records";
import { RefusedSince } from "../../parts/RefusedSince";
import { useRefreshed } from "../../refreshed";
import { KeysCard } from "./KeysCard";
import "./people.css";
import { PERSON, PersonSheet } from "./PersonSheet";
import { areaName } from "../../state";
import { begin, openings } from "./state";

const EVERY_MS = 10_000;

const HEADS = ["name", "role", "areas", "by", "actions"] as const;

/** The view, once it has its words. */
export async function load(): Promise<typeof People> {
  // What a key may do is told in the audit log, too.
  await speakAlso(records);
  await speakAlso(tables);
  return People;
}

/** Who may log in, where they work and by what they come in; and the keys of other systems. */
export function People() {
  const { again, answer, failed } = useRefreshed(fetchPeople, EVERY_MS);
  const people = answer.value ?? [];
  return (
    <Table
      title={t("nav.people")}
      heads={HEADS.map((head) => t(`people.${head}`))}
      hint={t("people.hint")}
      empty={failed.value === null ? t(answer.value ? "filter.none" : "view.loading") : t("list.failed", { reason: failed.value })}
      busy={answer.value === null && failed.value === null}
      aside={
        <button type="button" class="button primary" popovertarget={PERSON} onClick={() => { begin(null); }}>
          {t("people.add")}
        </button>
      }
      below={
        <>
          <RefusedSince of={openings} form={PERSON} />
          <PersonSheet onChanged={again} />
          <KeysCard />
        </>
      }
    >
      {people.map((person) => (
        <Row key={person.id} person={person} />
      ))}
    </Table>
  );
}

function Row({ person }: { person: Person }) {
  const { areas, disabled_at_s: disabledAtS, id, name, role, secrets } = person;
  return (
    <tr>
      <th scope="row" class="people-name">
        {name}
        {name !== id && <small class="line muted">{id}</small>}
      </th>
      <td>{word("person.role", role)}</td>
      <td>{role === "manager" ? t("people.everywhere") : format.list(areas.map(areaName))}</td>
      <td>
        {disabledAtS !== null ? <Tag tone="warn">{t("people.isDisabled")}</Tag> : secrets.length > 0 ? format.list(secrets.map((each) => word("people.secret", each))) : t("people.byLink")}
      </td>
      <td>
        <button type="button" class="button small" popovertarget={PERSON} aria-label={t("people.changeOf", { name })} onClick={() => { begin(person); }}>
          {t("people.change")}
        </button>
      </td>
    </tr>
  );
}
