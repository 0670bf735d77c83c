import { describe, expect, test } from "vitest";
import { shortageText } from "./shortage";
import { en as managerEn } from "./manager/en";
import { de as managerDe } from "./manager/de";
import { speak } from "./speech";

describe("what an order waits for", () => {
  test.each([
    ["for Rotor (storage S3 has none)", "Rotor (nothing in storage S3)"],
    [
      "for Rotor (storages S3, S4 have none and storage S5 does not answer); Shaft (storage S1 has none)",
      "Rotor (nothing in storage S3, S4, no answer from storage S5), Shaft (nothing in storage S1)",
    ],
    ["for something new", "something new"],
    ["M1 is silent", ""],
    ["", ""],
  ])("%s", (told, text) => {
    speak("en", managerEn, "en-GB");
    expect(shortageText(told)).toBe(text);
  });

  test("is told in the reader's language", () => {
    speak("de", managerDe, "de-DE");
    expect(shortageText("for Rotor (storage S3 has none)")).toBe("Rotor (nichts in Lager S3)");
    speak("en", managerEn, "en-GB");
  });
});
