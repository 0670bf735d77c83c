import { word } from "../../text/manager";
import type { FieldAttributes } from "../parts/Field";
import { isPriority, PRIORITIES, type Priority } from "./priority";

interface Props extends Partial<FieldAttributes> {
  readonly id: string;
  readonly value: Priority;
  readonly onChoose: (priority: Priority) => void;
}

/** How soon it is wanted, the most urgent first. */
export function PrioritySelect({ onChoose, value, ...attributes }: Props) {
  return (
    <select {...attributes} value={value} onChange={({ currentTarget: { value: chosen } }) => { if (isPriority(chosen)) onChoose(chosen); }}>
      {PRIORITIES.map((each) => (
        <option key={each} value={each}>
          {word("priority", each)}
        </option>
      ))}
    </select>
  );
}
