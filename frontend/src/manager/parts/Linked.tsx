import { Fragment } from "preact";

/** Stands in a sentence for the place of a link; no text that people read has it. */
export const HERE = "\uFFFC";

interface Props {
  /** With `HERE` for each link, in their order. */
  text: string;
  links: readonly { readonly href: string; readonly text: string; readonly label: string }[];
}

/** A sentence in which links stand. They open beside the page: what is written there stays. `label` says so. */
export function Linked({ links, text }: Props) {
  return (
    <>
      {text.split(HERE).map((piece, index) => {
        const before = links[index - 1];
        return (
          <Fragment key={index}>
            {before !== undefined && <a class="link" href={before.href} target="_blank" rel="noopener" aria-label={before.label}>{before.text}</a>}
            {piece}
          </Fragment>
        );
      })}
    </>
  );
}
