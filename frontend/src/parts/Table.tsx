/** A view that is one table. */
import type { ComponentChildren, VNode } from "preact";

interface Props {
  title: string;
  heads: readonly string[];
  empty: string;
  children: readonly VNode[];
}

export function Table({ children, empty, heads, title }: Props): ComponentChildren {
  return (
    <main class="table-view">
      <section class="card">
        <header class="card-head">
          <h1>{title}</h1>
          <span class="count">{children.length}</span>
        </header>
        {children.length === 0 ? (
          <p class="empty">{empty}</p>
        ) : (
          <div class="table-scroll" tabIndex={0} role="group" aria-label={title}>
            <table>
              <thead>
                <tr>
                  {heads.map((head) => (
                    <th key={head} scope="col">
                      {head}
                    </th>
                  ))}
                </tr>
              </thead>
              <tbody>{children}</tbody>
            </table>
          </div>
        )}
      </section>
    </main>
  );
}
