/** The name of an agent or task, to be chosen with a click. */
import { choose, type Chosen } from "../selection/selection";

interface Props {
  kind: Chosen["kind"];
  id: string;
  /** What people call it. */
  name?: string;
}

export function Link({ kind, id, name = id }: Props) {
  return (
    <button
      type="button"
      class="link"
      onClick={() => {
        choose({ kind, id });
      }}
    >
      {name}
    </button>
  );
}
