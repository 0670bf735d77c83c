/** Unit tests read English. */
import { en as manager } from "./manager/en";
import { en as operator } from "./operator/en";
import { speak } from "./speech";

speak("en", { ...operator, ...manager }, "en-GB");
