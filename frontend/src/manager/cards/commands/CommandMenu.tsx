import { world } from "../../../stream/stream";
import { t } from "../../../text/manager";
import { SheetButton } from "./SheetButton";

/** A button at the foot of a vehicle's card: what a person may tell it to do. */
export function CommandMenu({ atv: id }: { atv: string }) {
  return (
    <SheetButton
      label={t("tell.open")}
      title={t("tell.hint", { id })}
      load={async () => {
        const { VehicleActs } = await import("./VehicleActs");
        return () => {
          const atv = world.value?.atvs.get(id);
          return atv ? <VehicleActs atv={atv} /> : null;
        };
      }}
    />
  );
}
