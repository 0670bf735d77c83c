/** A view that is one table. */
import type { ComponentChildren, VNode } from "preact";
import { t } from "../text";

/** By which column the rows are sorted; whoever owns the rows sorts them. */
export interface Sorting {
  readonly column: number;
  readonly descending: boolean;
  readonly by: (column: number) => void;
}

interface Props {
  title: string;
  heads: readonly string[];
  empty: string;
  /** While it is not known yet whether there are rows. */
  busy?: boolean;
  /** How many there are, where not every row is one. */
  count?: number;
  /** What the figures mean, in a line below the title. */
  hint?: string;
  /** Right of the title: filters, a download. */
  aside?: ComponentChildren;
  sorting?: Sorting;
  /** Cards under the table. */
  below?: ComponentChildren;
  children: readonly VNode[];
}

export function Table({ aside, below, busy = false, children, count, empty, heads, hint, sorting, title }: Props): ComponentChildren {
  return (
    <main class="table-view" id="content" tabIndex={-1} aria-busy={busy}>
      <section class="card">
        <header class="card-head">
          <h1>{title}</h1>
          <span class="count">{count ?? children.length}</span>
          {aside !== undefined && <div class="table-aside">{aside}</div>}
        </header>
        {hint !== undefined && <p class="table-hint">{hint}</p>}
        {children.length === 0 ? (
          <p class="empty">{empty}</p>
        ) : (
          <div class="table-scroll" tabIndex={0} role="group" aria-label={title}>
            <table>
              <thead>
                <tr>
                  {heads.map((head, i) => (
                    <Head key={head} head={head} column={i} sorting={sorting} />
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

function Head({ column, head, sorting }: { column: number; head: string; sorting: Sorting | undefined }) {
  if (!sorting) return <th scope="col">{head}</th>;
  const sorted = sorting.column === column;
  const order = sorted ? (sorting.descending ? "descending" : "ascending") : "none";
  return (
    <th scope="col" aria-sort={order}>
      <button
        type="button"
        class="sort"
        title={t("table.sortBy", { column: head })}
        onClick={() => {
          sorting.by(column);
        }}
      >
        {head}
        <i class={`sort-mark sort-${order}`} aria-hidden="true" />
      </button>
    </th>
  );
}
