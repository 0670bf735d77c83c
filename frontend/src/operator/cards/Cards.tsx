import { VehicleCard } from "./VehicleCard";
import type { Left } from "./staying";

interface Props {
  ids: readonly string[];
  /** All that have a card, those that have left a moment ago among them. */
  all: ReadonlyMap<string, Left>;
  /** The one whose place was touched too soon after it came there. */
  tooSoon: string | null;
  label: string;
  class: string;
}

export function Cards({ all, class: name, ids, label, tooSoon }: Props) {
  const shown = ids.flatMap((id) => all.get(id) ?? []);
  if (shown.length === 0) return null;
  return (
    <ul class={`cards ${name}`} aria-label={label}>
      {shown.map(({ atMs, atv }) => (
        <VehicleCard key={atv.id} atv={atv} left={atMs !== null} tooSoon={tooSoon === atv.id} />
      ))}
    </ul>
  );
}
