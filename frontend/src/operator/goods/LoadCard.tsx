import type { ComponentChildren } from "preact";
import { isCutOff } from "../../parts/Carrying";
import { Tag } from "../../parts/Tag";
import { CommandLine } from "../commands/CommandLine";
import { ended } from "../session/session";

interface Props {
  id: string;
  title: string;
  /** A word that the title does not say. */
  tag?: string;
  /** What somebody looks for, and what is to be done about it. */
  what: string;
  look: string;
  /** The agent that asks. */
  asker: string;
  /** The buttons of the answers. */
  children: ComponentChildren;
}

/** A load about which somebody is asked. */
export function LoadCard({ asker, children, id, look, tag, title, what }: Props) {
  return (
    <li class="vehicle card machine-need need-help" id={id}>
      <div class="vehicle-body">
        <header>
          <h2>{title}</h2>
          {tag !== undefined && <Tag tone="warn">{tag}</Tag>}
        </header>
        <div class="vehicle-now">
          <p class="help-what">{what}</p>
          <p class="doing">{look}</p>
        </div>
        <div class="vehicle-acts">{children}</div>
        <CommandLine atv={asker} stopped={false} />
      </div>
    </li>
  );
}

/** No answer can be given: the session is over, or what is seen is old. */
export function isMute(): boolean {
  return ended.value !== null || isCutOff();
}
