/** A view that is one table. */
import type { ComponentChildren, VNode } from "preact";
import { format, t } from "../text";
import { Explained } from "./Explained";
import { columnsOf } from "./stacked";
import "./paper.css";

/** By which column the rows are sorted; whoever owns the rows sorts them. */
export interface Sorting {
  readonly column: number;
  readonly descending: boolean;
  readonly by: (column: number) => void;
  /** Whether rows can be sorted by it; all of them where nothing is said. */
  readonly can?: (column: number) => boolean;
}

interface Props {
  title: string;
  heads: readonly string[];
  /** What a column's word of the trade means, by column; empty where it explains itself. */
  explained?: readonly string[];
  empty: string;
  /** While it is not known yet whether there are rows. */
  busy?: boolean;
  /** How many there are, where not every row is one. */
  count?: number;
  /** Whether there are more than those that are shown. */
  more?: boolean;
  /** What the figures mean, in a line below the title. */
  hint?: string;
  /** What is to be said of these rows, above them. */
  note?: ComponentChildren;
  /** Right of the title: filters, a download. */
  aside?: ComponentChildren;
  sorting?: Sorting;
  /** Cards under the table. */
  below?: ComponentChildren;
  children: readonly VNode[];
}

export function Table({ aside, below, busy = false, children, count, empty, explained, heads, hint, more = false, note, sorting, title }: Props): ComponentChildren {
  return (
    <main class="table-view" id="content" tabIndex={-1} aria-busy={busy}>
      <section class="card">
        <header class="card-head">
          <h1>{title}</h1>
          <span class="count">{format.count(count ?? children.length)}{more && "+"}</span>
          {aside !== undefined && <div class="table-aside">{aside}</div>}
        </header>
        {hint !== undefined && <p class="table-hint">{hint}</p>}
        {note}
        {children.length === 0 ? (
          <p class="empty">{empty}</p>
        ) : (
          <div class="table-scroll" tabIndex={0} role="group" aria-label={title}>
            <table class="stacked" style={columnsOf(heads)}>
              <thead>
                <tr>
                  {heads.map((head, i) => (
                    <Head key={head} head={head} says={explained?.[i] ?? ""} column={i} sorting={sorting} />
                  ))}
                </tr>
              </thead>
              <tbody>{children}</tbody>
            </table>
          </div>
        )}
      </section>
      {below}
    </main>
  );
}

interface HeadProps {
  column: number;
  head: string;
  says: string;
  sorting: Sorting | undefined;
}

function Head({ column, head, says, sorting }: HeadProps) {
  if (!sorting || sorting.can?.(column) === false) return <th scope="col">{head}</th>;
  const sorted = sorting.column === column;
  const order = sorted ? (sorting.descending ? "descending" : "ascending") : "none";
  const sort = () => {
    sorting.by(column);
  };
  return (
    <th scope="col" aria-sort={order}>
      {says === "" ? (
        <button type="button" class="sort" title={t("table.sortBy", { column: head })} onClick={sort}>
          {head}
          <i class={`sort-mark sort-${order}`} aria-hidden="true" />
        </button>
      ) : (
        <Explained says={says}>
          {(about) => (
            <button type="button" class="sort" onClick={sort} {...about}>
              <span class="term">{head}</span>
              <i class={`sort-mark sort-${order}`} aria-hidden="true" />
            </button>
          )}
        </Explained>
      )}
    </th>
  );
}
