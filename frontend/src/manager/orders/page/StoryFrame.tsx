/** What the pages of an order and of a plain transport have in common: how they stand before there is anything to show, and when it could not be read anew. */
import type { ComponentChildren } from "preact";

interface Props {
  /** What the address names. */
  id: string;
  /** Why the last question had no answer, in words; null when it had. */
  failed: string | null;
  /** What is said while the first answer is waited for. */
  loading: string;
  /** Where all others are. */
  back: { readonly href: string; readonly text: string };
  /** The page; null as long as nothing is known. */
  children: ComponentChildren | null;
}

export function StoryFrame({ back, children, failed, id, loading }: Props) {
  if (children === null) {
    return (
      <main class="table-view" id="content" tabIndex={-1} aria-busy={failed === null}>
        <section class="card">
          <header class="card-head">
            <h1>{id}</h1>
          </header>
          <p class="empty" role="status">
            {failed ?? loading} <a class="quiet-link" href={back.href}>{back.text}</a>
          </p>
        </section>
      </main>
    );
  }
  return (
    <main class="order-page" id="content" tabIndex={-1}>
      {failed !== null && (
        <p class="tone-warn" role="status">
          {failed}
        </p>
      )}
      {children}
    </main>
  );
}
