import { selection } from "../../../selection/selection";
import { Card } from "../../../parts/Card";
import { world } from "../../../stream/stream";
import { t } from "../../../text/manager";
import { plant } from "../../state";
import { MachineCard } from "./MachineCard";
import { placeOf } from "./place";
import { PlaceCard } from "./PlaceCard";

/** Top right: whatever stands still and is chosen. */
export function ChosenPlace() {
  const id = selection.value.place?.id ?? "";
  const spec = plant.value?.machines.find((machine) => machine.id === id);
  if (spec) return <MachineCard spec={spec} machine={world.value?.machines.get(id)} />;
  const place = plant.value && placeOf(plant.value, id);
  if (place) return <PlaceCard place={place} />;
  return (
    <Card title={t("machine.title")} class="machine">
      <p class="empty">{t("machine.none")}</p>
    </Card>
  );
}
