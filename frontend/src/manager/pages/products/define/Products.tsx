import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { fetchDefinitions, fetchProducts } from "../../../../api/products";
import { Table } from "../../../../parts/Table";
import { Tag } from "../../../../parts/Tag";
import { nowS } from "../../../../stream/stream";
import { format, n, t, tables } from "../../../../text/views/products";
import { inFactoryTime } from "../../../../text/plant-time";
import { speakAlso } from "../../../../text/speech";
import { Choice } from "../../../parts/filters/Choice";
import { RefusedSince } from "../../../parts/RefusedSince";
import { names, plant } from "../../../state";
import { useRefreshed } from "../../../refreshed";
import "./products.css";
import { DefineForm, FORM } from "./DefineForm";
import { FileButton, FileSheet } from "./FileSheet";
import type { ProductAnswer } from "./draft";
import { begin, openings } from "./form";
import { NeedLinks } from "./NeedLinks";
import { authorsOf, type Definition, forget, tick, ticked } from "./remove";
import { RemoveBar } from "./RemoveBar";

const EVERY_MS = 10_000;

const HEADS = ["name", "revision", "bill", "lot", "machines", "documents", "definedBy"] as const;

/** The view, once it has its words. */
export async function load(): Promise<typeof Products> {
  await speakAlso(tables);
  return Products;
}

async function fetchAll(): Promise<{ products: ProductAnswer[]; definitions: Definition[] }> {
  // Asked anew as soon as another plant is known.
  plant.value?.plant.toString();
  const [products, definitions] = await Promise.all([fetchProducts(), fetchDefinitions()]);
  return { products, definitions };
}

/** What can be made, of what, and where; one is chosen to be changed, a new one defined, and those that nobody needs removed. */
export function Products() {
  const { again, answer, failed } = useRefreshed(fetchAll, EVERY_MS);
  const by = useSignal("");
  useEffect(() => forget, []);
  const all = answer.value?.products ?? [];
  const definitions = new Map((answer.value?.definitions ?? []).map((each) => [each.id, each]));
  const authors = authorsOf([...definitions.values()]);
  const isShown = (definition: Definition | undefined): boolean => by.value === "" || definition?.by === by.value;
  const products = all.filter(({ id }) => isShown(definitions.get(id)));
  const unfit = [...definitions.values()].filter((each) => each.state === "unfit" && isShown(each));
  const shown = [...definitions.values()].filter(isShown).map(({ id }) => id);
  return (
    <Table
      title={t("nav.products")}
      heads={HEADS.map((head) => (head === "machines" ? inFactoryTime(t("products.machines")) : t(`products.${head}`)))}
      hint={t("products.hint")}
      empty={failed.value === null ? t(answer.value ? "products.none" : "products.loading") : t("products.unread", { reason: failed.value })}
      busy={answer.value === null && failed.value === null}
      aside={
        <>
          {authors.length > 0 && (
            <>
              <Choice
                label={t("products.definedBy")}
                any={t("products.anybody")}
                value={by.value}
                options={authors.map(({ by: id, count }) => ({ id, name: t("products.author", { by: id, count: format.count(count) }) }))}
                onChosen={(author) => { by.value = author; }}
              />
              <button type="button" class="button" disabled={shown.length === 0} onClick={() => { tick(shown, true); }}>
                {n("products.tickAll", shown.length, format.count(shown.length))}
              </button>
            </>
          )}
          <button type="button" class="button primary" popovertarget={FORM} onClick={() => { begin(null); }}>
            {t("products.define")}
          </button>
          <FileButton />
        </>
      }
      below={
        <>
          <div class="removal">
            <RemoveBar definitions={[...definitions.values()]} onRemoved={again} />
            <NeedLinks />
          </div>
          <RefusedSince of={openings} form={FORM} />
          <DefineForm onDefined={again} />
          <FileSheet onTaken={again} />
        </>
      }
    >
      {[
        ...products.map((product) => <Row key={product.id} product={product} definition={definitions.get(product.id)} />),
        ...unfit.map((definition) => <UnfitRow key={definition.id} definition={definition} />),
      ]}
    </Table>
  );
}

/** Who has defined it, with a box to tick: what stands in the plant file cannot be removed here. */
function Author({ definition }: { definition: Definition | undefined }) {
  if (!definition) return <td class="muted">{t("products.plantFile")}</td>;
  return (
    <td>
      <span class="author">
        <label class="tick">
          <input
            type="checkbox"
            aria-label={t("products.tickOf", { name: definition.name })}
            checked={ticked.value.has(definition.id)}
            onChange={(event) => { tick([definition.id], event.currentTarget.checked); }}
          />
        </label>
        <span>
          {definition.by}
          <small class="line muted">{format.when(definition.at_s, nowS.value)}</small>
        </span>
      </span>
    </td>
  );
}

/** One that was defined for another plant file: it counts, and nobody can order it. */
function UnfitRow({ definition }: { definition: Definition }) {
  return (
    <tr>
      <th scope="row">
        {definition.name}
        <small class="line muted">{definition.id}</small>
      </th>
      <td class="num">{format.count(definition.revision)}</td>
      <td>
        <Tag tone="warn">{t("products.unfit")}</Tag>
      </td>
      <td />
      <td />
      <td />
      <Author definition={definition} />
    </tr>
  );
}

function Row({ definition, product }: { definition: Definition | undefined; product: ProductAnswer }) {
  const bill = Object.entries(product.bill).map(([material, pieces]) => `${format.count(pieces)} ${names.value(material)}`);
  const machines = Object.entries(product.machines).map(([machine, cycleS]) => t("products.cycle", { machine, cycle: format.duration(cycleS) }));
  return (
    <tr>
      <th scope="row">
        <button type="button" class="link" popovertarget={FORM} title={t("products.change", { name: product.name })} onClick={() => { begin(product); }}>
          {product.name}
        </button>
        <small class="line muted">{product.id}</small>
      </th>
      <td class="num">{format.count(product.revision)}</td>
      <td>{format.list(bill)}</td>
      <td class="num">{n("products.pieces", product.lot, format.count(product.lot))}</td>
      <td>{format.list(machines)}</td>
      <td>
        {product.documents.map((document) => (
          <a key={document.name} class="line link" href={document.address} target="_blank" rel="noreferrer noopener">
            {document.name}
          </a>
        ))}
      </td>
      <Author definition={definition} />
    </tr>
  );
}
