import type { AuditLine } from "../../../api/types";
import { Table } from "../../../parts/Table";
import { Tag } from "../../../parts/Tag";
import { nowS } from "../../../stream/stream";
import { speakAlso } from "../../../text/speech";
import { tables as faultTables } from "../../../text/views/faults";
import { format, t, tables, word } from "../../../text/views/records";
import { ListKeptNote } from "../../parts/kept/KeptNote";
import { Pages } from "../../parts/pages/Pages";
import { PrintButton } from "../../parts/paper/PrintButton";
import { countOf, narrow } from "../../parts/pages/paged";
import { addressOf, addressOfTransport, isTransport, transportOf } from "../../views";
import { detailText } from "./detail";
import { Filters } from "./Filters";
import { oldestFirst, useLog } from "./log";

const HEADS = ["at", "who", "action", "target", "result", "detail"] as const;

/** The view, once it has its words. */
export async function load(): Promise<typeof AuditList> {
  await Promise.all([speakAlso(tables), speakAlso(faultTables)]);
  return AuditList;
}

/** Who did what, when, from where, and what came of it. */
export function AuditList() {
  const { failed, page, printing } = useLog();
  const lines = page.value?.items ?? [];
  return (
    <Table
      title={t("audit.title")}
      heads={HEADS.map((head) => t(`audit.${head}`))}
      hint={t("audit.hint")}
      empty={emptyText(page.value === null, failed.value)}
      busy={page.value === null && failed.value === null}
      {...countOf(page.value)}
      sorting={{
        column: 0,
        descending: !oldestFirst.value,
        by: () => { narrow({ sort: oldestFirst.value ? "" : "oldest" }); },
        can: (column) => column === 0,
      }}
      note={<ListKeptNote kind="audit" />}
      aside={<><Filters /><PrintButton of={printing} /></>}
      below={<Pages next={page.value?.next_cursor ?? null} />}
    >
      {lines.map((line) => (
        <Row key={line.position} line={line} />
      ))}
    </Table>
  );
}

function emptyText(isLoading: boolean, failed: string | null): string {
  if (failed !== null) return t("audit.failed", { reason: failed });
  return t(isLoading ? "audit.loading" : "audit.empty");
}

function Row({ line }: { line: AuditLine }) {
  const { action, at_s, detail, from_ip, result, target, who, who_kind } = line;
  return (
    <tr>
      <td class="num">
        {format.when(at_s, nowS.value)}
      </td>
      <th scope="row">
        {who === "" ? word("audit.kind", who_kind) : <Only what={who} by={{ who }} />}
        <small class="line muted">
          {[who !== "" && who_kind !== "person" && word("audit.kind", who_kind), from_ip !== "" && t("audit.from", { ip: from_ip })]
            .filter(Boolean)
            .join(" · ")}
        </small>
      </th>
      <td>{word("audit.did", action)}</td>
      <td>{target !== "" && <Target line={line} />}</td>
      <td>{result === "done" ? word("audit.came", result) : <Tag tone="warn">{word("audit.came", result)}</Tag>}</td>
      <td class="audit-detail">{detailText(detail)}</td>
    </tr>
  );
}

/** What a line is about that has a page; empty for all else. */
function pageOf({ action, is_order: isOrder, target }: AuditLine): string {
  if (isOrder) return addressOf(target);
  if (isTransport(target)) return addressOfTransport(target);
  return action === "load.see" ? addressOfTransport(transportOf(target) || target) : "";
}

/** An order by its customer's number, and a transport, with the way to its page. */
function Target({ line }: { line: AuditLine }) {
  const { reference, target } = line;
  const page = pageOf(line);
  if (page === "") return <Only what={target} by={{ target }} />;
  const name = reference ?? target;
  return (
    <>
      <a class="link" href={page}>
        {name}
      </a>{" "}
      <button type="button" class="button small" onClick={() => { narrow({ target }); }}>
        {t("audit.only", { what: name })}
      </button>
    </>
  );
}

function Only({ by, what }: { what: string; by: Parameters<typeof narrow>[0] }) {
  return (
    <button type="button" class="link" title={t("audit.only", { what })} onClick={() => { narrow(by); }}>
      {what}
    </button>
  );
}
