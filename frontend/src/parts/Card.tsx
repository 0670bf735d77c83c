/** A card: heading, something on its right, content. */
import type { ComponentChildren } from "preact";
import { useId } from "preact/hooks";

interface Props {
  title: ComponentChildren;
  aside?: ComponentChildren;
  class?: string;
  /** Its content may be longer than the card. Then the content takes the focus, so that the keyboard scrolls it also where it holds no link and no button. */
  scrolls?: boolean;
  /** What can be done: below the content, and whole however long that is. */
  foot?: ComponentChildren;
  children: ComponentChildren;
}

export function Card({ title, aside, class: name = "", children, foot, scrolls = false }: Props) {
  const id = useId();
  return (
    <section class={`card ${name}`} aria-labelledby={id}>
      <header class="card-head">
        <h2 id={id}>{title}</h2>
        {aside !== undefined && <div class="card-aside">{aside}</div>}
      </header>
      <div class="card-body" tabIndex={scrolls ? 0 : undefined}>
        {children}
      </div>
      {foot !== undefined && <div class="card-foot chosen-acts">{foot}</div>}
    </section>
  );
}
