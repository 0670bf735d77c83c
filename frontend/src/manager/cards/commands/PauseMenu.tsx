import { t } from "../../../text/manager";
import { plant } from "../../state";
import { SheetButton } from "./SheetButton";

/** A button at the foot of the factory's card: pause an area. */
export function PauseMenu() {
  if ((plant.value?.areas ?? []).length === 0) return null;
  return (
    <SheetButton
      label={t("pause.open")}
      title={t("pause.hint")}
      load={async () => {
        const { PauseForm } = await import("./PauseForm");
        return () => <PauseForm />;
      }}
    />
  );
}
