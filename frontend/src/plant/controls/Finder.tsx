import { useSignal } from "@preact/signals";
import { Icon } from "../../parts/Icon";
import { choose } from "../../selection/selection";
import { world } from "../../stream/stream";
import { t } from "../../text";
import type { PlantFile } from "../../api/types";
import { find, type Findable, findablesOf } from "../places";

const MOST = 8;

interface Props {
  plant: PlantFile;
  onChosen: (found: Findable) => void;
}

/** Chooses anything on the map by name: the way for the keyboard, and in a plant of hundreds for everybody. */
export function Finder({ plant, onChosen }: Props) {
  const words = useSignal("");
  const open = useSignal(false);
  const active = useSignal(0);
  const found = open.value ? find(findablesOf(plant, world.value?.atvs.values() ?? []), words.value, MOST) : [];
  const listed = found.length > 0;
  const take = (each: Findable | undefined): void => {
    if (!each) return;
    choose(each.chosen);
    onChosen(each);
    words.value = "";
    open.value = false;
  };
  const onKeyDown = (event: KeyboardEvent): void => {
    const count = found.length;
    if (event.key === "Enter") take(found[active.value]);
    else if (event.key === "Escape") open.value = false;
    else if (event.key === "ArrowDown") active.value = Math.min(count - 1, active.value + 1);
    else if (event.key === "ArrowUp") active.value = Math.max(0, active.value - 1);
    else return;
    event.preventDefault();
  };
  return (
    <div class="finder">
      <Icon name="search" />
      <input
        role="combobox"
        aria-label={t("map.find")}
        aria-expanded={listed}
        aria-controls="finder-list"
        aria-autocomplete="list"
        aria-activedescendant={listed ? `finder-${active.value}` : undefined}
        placeholder={t("map.find")}
        autoComplete="off"
        value={words.value}
        onFocus={() => (open.value = true)}
        onBlur={() => (open.value = false)}
        onInput={(event) => {
          words.value = event.currentTarget.value;
          active.value = 0;
          open.value = true;
        }}
        onKeyDown={onKeyDown}
      />
      {listed && (
        <ul id="finder-list" role="listbox" class="finder-list card" aria-label={t("map.find")}>
          {found.map((each, i) => (
            <li
              key={`${each.chosen.kind}${each.id}`}
              id={`finder-${i}`}
              role="option"
              aria-selected={i === active.value}
              // Before the field loses the focus and the list goes away.
              onPointerDown={(event) => {
                event.preventDefault();
                take(each);
              }}
            >
              <b>{each.id}</b>
              <span class="clip">{each.name}</span>
              <span class="faint">{t(`map.kind.${each.chosen.kind as "atv" | "machine" | "place"}`)}</span>
            </li>
          ))}
        </ul>
      )}
      {open.value && !listed && (
        <p role="status" class="finder-list card faint">
          {t("map.findNone")}
        </p>
      )}
    </div>
  );
}
