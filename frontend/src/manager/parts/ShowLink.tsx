/** Leads from a table to the plant, with this one chosen. */
import { go } from "../views";
import { choose, type Chosen } from "../../selection/selection";

interface Props {
  chosen: Chosen;
  label: string;
  /** What people call it. */
  name?: string;
}

export function ShowLink({ chosen, label, name = chosen.id }: Props) {
  return (
    <button
      type="button"
      class="link"
      aria-label={label}
      onClick={() => {
        choose(chosen);
        go("plant");
      }}
    >
      {name}
    </button>
  );
}
