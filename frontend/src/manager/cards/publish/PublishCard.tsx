import { Card } from "../../../parts/Card";
import { t } from "../../../text/manager";
import { PrioritySelect } from "../../orders/PrioritySelect";
import { plant } from "../../state";
import { Field } from "./Field";
import { draft, edit, send, sending } from "./form";
import { Feasible } from "./Feasible";

/** Defines an order (stored) or publishes it (the factory starts). */
export function PublishCard() {
  const products = plant.value?.products ?? [];
  const { customer, due, priority, product, quantity, reference } = draft.value;
  const off = sending.value || products.length === 0;
  return (
    <Card title={t("publish.title")} class="publish">
      <form
        class="form"
        noValidate
        onSubmit={(event) => {
          event.preventDefault();
          void send(true);
        }}
      >
        <Field field="product" label={t("publish.product")}>
          {(attributes) => (
            <select {...attributes} value={product} onChange={(event) => { edit("product", event.currentTarget.value); }}>
              {product === "" && products.length > 0 && <option value="">{t("publish.choose")}</option>}
              {products.map(({ id, name }) => (
                <option key={id} value={id}>
                  {name}
                </option>
              ))}
            </select>
          )}
        </Field>
        <Field field="quantity" label={t("publish.quantity")}>
          {(attributes) => (
            <input {...attributes} inputMode="numeric" autoComplete="off" value={quantity} onInput={(event) => { edit("quantity", event.currentTarget.value); }} />
          )}
        </Field>
        <Field field="priority" label={t("orders.priority")}>
          {(attributes) => <PrioritySelect {...attributes} value={priority} onChoose={(chosen) => { edit("priority", chosen); }} />}
        </Field>
        <Field field="customer" label={t("publish.customer")}>
          {(attributes) => (
            <input {...attributes} autoComplete="off" maxLength={80} value={customer} onInput={(event) => { edit("customer", event.currentTarget.value); }} />
          )}
        </Field>
        <Field field="reference" label={t("publish.reference")} optional>
          {(attributes) => (
            <input {...attributes} autoComplete="off" maxLength={80} value={reference} onInput={(event) => { edit("reference", event.currentTarget.value); }} />
          )}
        </Field>
        <Field field="due" label={t("publish.due")} optional>
          {(attributes) => (
            <input {...attributes} type="datetime-local" value={due} onInput={(event) => { edit("due", event.currentTarget.value); }} />
          )}
        </Field>
        <div class="feasible" role="status">
          <Feasible />
        </div>
        <div class="form-actions">
          <button type="button" class="button" disabled={off} onClick={() => void send(false)}>
            {t("publish.define")}
          </button>
          <button type="submit" class="button primary" disabled={off}>
            {t(sending.value ? "publish.busy" : "publish.publish")}
          </button>
        </div>
      </form>
    </Card>
  );
}
