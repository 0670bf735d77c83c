import { useEffect } from "preact/hooks";
import type { AuditRow } from "../../../api/types";
import { Table } from "../../../parts/Table";
import { Tag } from "../../../parts/Tag";
import { nowS } from "../../../stream/stream";
import { format, t, word } from "../../../text/manager";
import { detailText } from "./filter";
import { Filters } from "./Filters";
import { cursors, failed, followLog, lookAgain, narrow, newer, older, page } from "./log";

const HEADS = ["at", "who", "action", "target", "result", "detail"] as const;

/** Who did what, when, from where, and what came of it. */
export function AuditView() {
  useEffect(followLog, []);
  const lines = page.value?.items ?? [];
  return (
    <Table
      title={t("audit.title")}
      heads={HEADS.map((head) => t(`audit.${head}`))}
      hint={t("audit.hint")}
      empty={emptyText()}
      busy={page.value === null && failed.value === ""}
      aside={<Filters />}
      below={<Pages />}
    >
      {lines.map((line) => (
        <Row key={line.position} line={line} />
      ))}
    </Table>
  );
}

function emptyText(): string {
  if (failed.value !== "") return t("audit.failed", { reason: failed.value });
  return t(page.value ? "audit.empty" : "audit.loading");
}

function Row({ line }: { line: AuditRow }) {
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
      <td>{target !== "" && <Only what={target} by={{ target }} />}</td>
      <td>{result === "done" ? word("audit.came", result) : <Tag tone="warn">{word("audit.came", result)}</Tag>}</td>
      <td class="audit-detail">{detailText(detail)}</td>
    </tr>
  );
}

function Only({ by, what }: { what: string; by: Parameters<typeof narrow>[0] }) {
  return (
    <button type="button" class="link" title={t("audit.only", { what })} onClick={() => { narrow(by); }}>
      {what}
    </button>
  );
}

function Pages() {
  const first = cursors.value.length === 1;
  if (first && !page.value?.next_cursor) return null;
  return (
    <div class="pages">
      <button type="button" class="button small" disabled={first} onClick={newer}>
        {t("audit.newer")}
      </button>
      <button type="button" class="button small" disabled={!page.value?.next_cursor} onClick={older}>
        {t("audit.older")}
      </button>
      {!first && (
        <button type="button" class="button small" onClick={lookAgain}>
          {t("audit.again")}
        </button>
      )}
    </div>
  );
}
