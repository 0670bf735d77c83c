import { computed, signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { BufferView } from "../../api/types";
import { GATE } from "../../plant/places";
import { selection } from "../../selection/selection";
import { world } from "../../stream/stream";
import { vehicleName } from "../../text/elsewhere";
import { format, n, t } from "../../text/operator";
import { me } from "../session/session";
import { names, plant } from "../state";
import { type Choice, isWhole, itemsFor, kindsAt, ofGoal, ofKind, ofLoad, type Place, scanned, withItem, withQuantity } from "./choice";
import { NOTHING, pressed } from "../../parts/scan";
import { answer, type At, doubted, goOn, last, say, waiting } from "./words";
import "./words.css";

/** Chosen at which place, and what. */
const chosen = signal<{ readonly place: string; readonly choice: Choice } | null>(null);
const unknown = signal("");

interface Worked extends Place, At {
  readonly buffers: readonly { readonly item: string; readonly level: number; readonly on_order: number }[];
}

/** The place that was touched on the map, else where this person works, else the only one here that people work. */
const worked = computed<Worked | null>(() => {
  const touched = workedAt(agentOf(selection.value.place?.id ?? ""));
  if (touched) return touched.unconfirmed ? touched : null;
  const own = workedAt(me.value?.station ?? "");
  if (own?.unconfirmed) return own;
  const { machines, stations } = world.value ?? {};
  const [only, ...others] = [...(machines?.values() ?? []), ...(stations?.values() ?? [])].filter((each) => each.unconfirmed !== null);
  return only === undefined || others.length > 0 ? null : workedAt(only.id);
});

/** Of a place on the map; the delivery warehouses have one gate. */
function agentOf(id: string): string {
  const isDelivery = plant.value?.warehouses.some((each) => each.id === id && each.kind === "delivery") ?? false;
  return isDelivery ? GATE : id;
}

/** A machine or a station, whoever works there; null for what is neither, or was not heard yet. */
function workedAt(id: string): Worked | null {
  const machine = world.value?.machines.get(id);
  if (machine) return { ...machine, station: false, toCome: null };
  const station = world.value?.stations.get(id);
  if (!station) return null;
  const { stocks: buffers, to_come: toCome, unconfirmed } = station;
  return { id, station: true, buffers, goods: [], product: "", unconfirmed, toCome: id === GATE ? toCome : null };
}

/** What has happened at a place that people work: a first touch or code chooses, a second one says it. */
export function WordsCard() {
  const place = worked.value;
  return place && <Words place={place} />;
}

function choose(place: string, choice: Choice): void {
  chosen.value = { place, choice };
  unknown.value = "";
}

function sayIt(at: At, choice: Choice): void {
  chosen.value = null;
  say(at, choice);
}

function Words({ place }: { place: Worked }) {
  const { id } = place;
  useEffect(goOn);
  useEffect(() => listen(id), [id]);
  const choice = chosen.value?.place === id ? chosen.value.choice : null;
  const title = place.toCome ? t("words.gate") : t("words.title", { id });
  return (
    <section class="words card" aria-label={title}>
      <h2>{title}</h2>
      {!place.toCome && (
        <div class="words-what">
          {kindsAt(place).map((kind) => (
            <button
              key={kind}
              type="button"
              class="words-kind"
              aria-pressed={choice?.kind === kind && choice.vehicle === ""}
              onClick={() => { choose(id, ofKind(kind, place)); }}
            >
              {t(`command.${kind}`)}
            </button>
          ))}
        </div>
      )}
      <Second place={place} choice={choice} />
      {/* Below all else: one that comes moves nothing under a finger. */}
      <div class="words-what">
        {(place.toCome ?? []).map((each) => (
          <button
            key={each.goal}
            type="button"
            class="words-load"
            aria-pressed={choice?.item === each.goal}
            onClick={() => { choose(id, ofGoal(each)); }}
          >
            {t("words.toCome", { item: itemName(each.goal), quantity: format.count(each.quantity) })} <b>{t("words.allThere")}</b>
          </button>
        ))}
        {(place.unconfirmed ?? []).map((load, i) => {
          const mine = ofLoad(load);
          const what = { vehicle: vehicleName(load.vehicle), quantity: format.count(load.quantity), item: names.value(load.item) };
          return (
            <button
              key={`${load.vehicle}-${load.item}-${i}`}
              type="button"
              class="words-load"
              aria-pressed={choice?.vehicle === load.vehicle && choice.item === load.item && choice.kind === mine.kind}
              onClick={() => { choose(id, mine); }}
            >
              {t(load.goes ? "words.took" : "words.brought", what)} <b>{t("words.right")}</b>
            </button>
          );
        })}
      </div>
      {place.station && place.buffers.filter((each) => each.on_order > 0).map((each) => (
        <p key={each.item}>{leaveRoomText(each)}</p>
      ))}
      {waiting.value.length > 0 && <p class="tone-warn">{t("words.waiting", { count: format.count(waiting.value.length) })}</p>}
    </section>
  );
}

/** That there must be room for what comes. */
function leaveRoomText({ item, on_order }: Pick<BufferView, "item" | "on_order">): string {
  return n("words.leaveRoom", on_order, `${format.count(on_order)} ${names.value(item)}`);
}

/** The place of the second touch is always there, so that nothing moves under a finger. */
function Second({ choice, place }: { place: Worked; choice: Choice | null }) {
  const { id } = place;
  const asked = doubted.value;
  if (choice === null && asked !== null) {
    const quantity = format.count(asked.quantity);
    return (
      <div class="words-second" role="alert">
        <p><b>{whatText(asked, asked.place)}</b> {t("words.unlikely", { expected: asked.doubted ?? "", quantity })}</p>
        <div class="words-say">
          <button type="button" class="button primary words-yes" onClick={() => { answer(true); }}>{t("words.sure", { quantity })}</button>
          <button type="button" class="button" onClick={() => { answer(false); }}>{t("words.no")}</button>
        </div>
      </div>
    );
  }
  if (choice === null) {
    return <div class="words-second" role="status"><p class="muted">{becameText()}</p></div>;
  }
  const item = choice.item;
  const more = (by: number): void => { choose(id, withQuantity(choice, choice.quantity + by)); };
  return (
    <div class="words-second" role="status">
      {choice.vehicle === "" && !place.toCome && (
        <div class="words-items" role="group" aria-label={t("words.item")}>
          {itemsFor(choice.kind, place).map((each) => (
            <button key={each} type="button" class="button" aria-pressed={each === item} onClick={() => { choose(id, withItem(choice, each, place)); }}>
              {names.value(each)}
            </button>
          ))}
        </div>
      )}
      {item !== "" && (
        <div class="words-say">
          <button type="button" class="button" aria-label={t("words.less")} onClick={() => { more(-1); }}>−</button>
          <input
            type="number"
            inputMode="numeric"
            min={0}
            aria-label={t("words.number")}
            value={choice.quantity}
            onInput={({ currentTarget: { valueAsNumber } }) => { choose(id, withQuantity(choice, valueAsNumber)); }}
          />
          <button type="button" class="button" aria-label={t("words.more")} onClick={() => { more(1); }}>+</button>
          <button type="button" class="button primary words-yes" disabled={!isWhole(choice)} onClick={() => { sayIt(place, choice); }}>
            {whatText(choice, id)}
          </button>
        </div>
      )}
    </div>
  );
}

/** A material's or a product's name; of a goal its product and what its label says. */
function itemName(item: string): string {
  const goal = world.value?.stations.get(GATE)?.to_come.find((each) => each.goal === item);
  if (goal === undefined || goal.product === "") return names.value(item);
  return t("words.ofGoal", { item: names.value(goal.product), goal: item });
}

function whatText({ item, kind, quantity, vehicle }: Choice, place: string): string {
  const what = { item: itemName(item), quantity: format.count(quantity) };
  if (place === GATE) return t("words.say.in", what);
  if (vehicle === "" || (kind !== "arrived" && kind !== "taken")) return t(`words.say.${kind}`, what);
  return t(`words.say.${kind}With`, { ...what, vehicle: vehicleName(vehicle) });
}

function becameText(): string {
  if (unknown.value !== "") return t("words.unknown", { code: unknown.value });
  if (last.value === null) return t("words.first");
  return t(`words.${last.value.became}`, { what: whatText(last.value.word, last.value.word.place), reason: last.value.reason });
}

/** Hears a scanner that types like a keyboard, wherever the focus is but in a field. */
function listen(id: string): () => void {
  let scan = NOTHING;
  const onKey = (event: KeyboardEvent): void => {
    if (event.ctrlKey || event.altKey || event.metaKey || event.isComposing || isField(event.target)) return;
    const [after, code] = pressed(scan, event.key, event.timeStamp);
    scan = after;
    if (code === null) return;
    // Else a button that has the focus would be pressed by it.
    event.preventDefault();
    event.stopPropagation();
    take(id, code);
  };
  document.addEventListener("keydown", onKey, true);
  return () => { document.removeEventListener("keydown", onKey, true); };
}

function isField(target: EventTarget | null): boolean {
  return target instanceof HTMLInputElement || target instanceof HTMLTextAreaElement || target instanceof HTMLSelectElement;
}

function take(id: string, code: string): void {
  const place = workedAt(id);
  if (place === null) return;
  const before = chosen.value?.place === id ? chosen.value.choice : null;
  const step = scanned(code, before, place);
  if (step.does === "unknown") unknown.value = code;
  else if (step.does === "choose") choose(id, step.choice);
  else sayIt(place, step.choice);
}
