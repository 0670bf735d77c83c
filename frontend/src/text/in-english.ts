/** Unit tests read English. */
import { en as manager } from "./manager/en";
import { en as operator } from "./operator/en";
import { speak } from "./speech";
import { guide } from "./views/guide/en";
import { order } from "./views/order/en";
import { products } from "./views/products/en";
import { recurring } from "./views/recurring/en";
import { records } from "./views/records/en";
import { replay } from "./views/replay/en";
import { rows } from "./views/rows/en";
import { scenario } from "./views/scenario/en";

speak("en", { ...operator, ...manager, ...guide, ...order, ...products, ...records, ...recurring, ...replay, ...rows, ...scenario }, "en-GB");
