import { fetchProducts } from "../../../../api/products";
import { Table } from "../../../../parts/Table";
import { format, n, t, tables } from "../../../../text/views/products";
import { factoryTime } from "../../../../text/plant-time";
import { speakAlso } from "../../../../text/speech";
import { names } from "../../../state";
import { useRefreshed } from "../../../refreshed";
import "./products.css";
import { DefineForm, FORM } from "./DefineForm";
import { FileButton, FileSheet } from "./FileSheet";
import type { ProductAnswer } from "./draft";
import { begin } from "./form";

const EVERY_MS = 10_000;

const HEADS = ["name", "revision", "bill", "lot", "machines", "documents"] as const;

/** The view, once it has its words. */
export async function load(): Promise<typeof Products> {
  await speakAlso(tables);
  return Products;
}

/** What can be made, of what, and where; one is chosen to be changed, or a new one defined. */
export function Products() {
  const { again, answer, failed } = useRefreshed(fetchProducts, EVERY_MS);
  const products = answer.value ?? [];
  return (
    <Table
      title={t("nav.products")}
      heads={HEADS.map((head) => t(`products.${head}`))}
      hint={t("products.hint")}
      empty={failed.value === null ? t(answer.value ? "products.none" : "products.loading") : t("products.unread", { reason: failed.value })}
      busy={answer.value === null && failed.value === null}
      aside={
        <>
          <button type="button" class="button primary" popovertarget={FORM} onClick={() => { begin(null); }}>
            {t("products.define")}
          </button>
          <FileButton />
        </>
      }
      below={
        <>
          <DefineForm onDefined={again} />
          <FileSheet onTaken={again} />
        </>
      }
    >
      {products.map((product) => (
        <Row key={product.id} product={product} />
      ))}
    </Table>
  );
}

function Row({ product }: { product: ProductAnswer }) {
  const bill = Object.entries(product.bill).map(([material, pieces]) => `${format.count(pieces)} ${names.value(material)}`);
  const machines = Object.entries(product.machines).map(([machine, cycleS]) => t("products.cycle", { machine, cycle: factoryTime(cycleS) }));
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
    </tr>
  );
}
