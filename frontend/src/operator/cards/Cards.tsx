import { world } from "../../stream/stream";
import { VehicleCard } from "./VehicleCard";

interface Props {
  ids: readonly string[];
  label: string;
  class: string;
}

export function Cards({ class: name, ids, label }: Props) {
  const atvs = ids.flatMap((id) => world.value?.atvs.get(id) ?? []);
  if (atvs.length === 0) return null;
  return (
    <ul class={`cards ${name}`} aria-label={label}>
      {atvs.map((atv) => (
        <VehicleCard key={atv.id} atv={atv} />
      ))}
    </ul>
  );
}
