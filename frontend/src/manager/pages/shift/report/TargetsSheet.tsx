import { useSignal } from "@preact/signals";
import { inFactoryTime } from "../../../../text/plant-time";
import { t, word } from "../../../../text/views/shift";
import { Sheet } from "../../../parts/Sheet";
import { problemText } from "../../../problem-text";
import { putTargets } from "./api";
import { type Figure, type Targets } from "./shifts";

interface Props {
  figures: readonly Figure[];
  targets: Targets;
  onSaved: () => void;
}

export const TARGETS_ID = "shift-targets";

/** What figures should reach; a field that is empty has no target. */
export function TargetsSheet({ figures, onSaved, targets }: Props) {
  const said = useSignal("");
  const save = async (event: SubmitEvent): Promise<void> => {
    event.preventDefault();
    const form = new FormData(event.currentTarget as HTMLFormElement);
    const wanted: Record<string, number> = {};
    for (const { name, unit } of figures) {
      const text = form.get(name);
      if (typeof text === "string" && text !== "") wanted[name] = Number(text) / (unit === "frac" ? 100 : 1);
    }
    try {
      await putTargets(wanted);
      said.value = t("targets.saved");
      onSaved();
    } catch (error) {
      said.value = t("targets.failed", { reason: problemText(error) });
    }
  };
  return (
    <Sheet id={TARGETS_ID} title={t("shift.targets")}>
      <p>
        {t("targets.hint")} {targets.by !== "" && t("targets.by", { by: targets.by })}
      </p>
      <form class="shift-targets" onSubmit={(event) => void save(event)}>
        {figures.map(({ better, name, unit }) => {
          const value = targets.targets[name];
          const of = better === "more" ? "≥" : "≤";
          return (
            <label key={name}>
              <span>{unit === "s" ? inFactoryTime(word("shift.f", name)) : word("shift.f", name)} {of}</span>
              <input name={name} type="number" min={0} max={unit === "frac" ? 100 : 1e9} step="any" defaultValue={value === undefined ? "" : String(Math.round(value * (unit === "frac" ? 1e4 : 100)) / 100)} />
              <small>{unit === "frac" ? "%" : unit === "Wh" || unit === "s" ? unit : ""}</small>
            </label>
          );
        })}
        <div class="shift-save">
          <button type="submit" class="button primary">{t("targets.save")}</button>
          <span role="status">{said.value}</span>
        </div>
      </form>
    </Sheet>
  );
}
