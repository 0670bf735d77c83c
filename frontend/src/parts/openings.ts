/** A form that is opened for one thing after another: an answer belongs to what was open when it was sent. */
import { signal } from "@preact/signals";

/** What an `Openings` needs of its form. */
export interface Form<Fields> {
  /** What stands in it, with what it is about. */
  readonly read: () => Fields;
  readonly write: (fields: Fields) => void;
  /** Shows in it why something was refused. */
  readonly complain: (error: unknown) => void;
  /** The same beside it, in one sentence that names the thing. */
  readonly tell: (fields: Fields, error: unknown) => string;
}

/** What was refused after its form was opened for something else. */
export interface Refused {
  readonly text: string;
  /** Opens the thing in the form again, with all that was typed and its complaints. */
  readonly restore: () => void;
}

/** Refusals that are kept: more than anybody causes before looking at the first. */
const REFUSED_MAX = 10;

/** Counts how often a form was opened, and keeps what was typed for a thing that is refused later. */
export class Openings<Fields> {
  /** What is told beside the form, oldest first. */
  readonly refused = signal<readonly Refused[]>([]);
  #opened = 0;
  #leaving: (() => void)[] = [];

  constructor(private readonly form: Form<Fields>) {}

  /** The form is opened for something, and its fields have not changed yet. */
  begin(): void {
    for (const leave of this.#leaving.splice(0)) leave();
    this.#opened += 1;
  }

  /**
   * Sends what is open; a refusal is told in the form, or beside it if something else is open by then.
   *
   * @param act is told whether what was sent is still open
   * @returns whether it was done
   */
  async send(act: (isOpen: () => boolean) => Promise<void>): Promise<boolean> {
    const opening = this.#opened;
    const isOpen = (): boolean => opening === this.#opened;
    let left = this.form.read();
    const leave = (): void => { left = this.form.read(); };
    this.#leaving.push(leave);
    try {
      await act(isOpen);
      return true;
    } catch (error) {
      if (isOpen()) this.form.complain(error);
      else this.#refuse(left, error);
      return false;
    } finally {
      this.#leaving = this.#leaving.filter((each) => each !== leave);
    }
  }

  drop(refused: Refused): void {
    this.refused.value = this.refused.value.filter((each) => each !== refused);
  }

  #refuse(fields: Fields, error: unknown): void {
    const restore = (): void => {
      this.drop(refused);
      this.begin();
      this.form.write(fields);
      this.form.complain(error);
    };
    const refused: Refused = { text: this.form.tell(fields, error), restore };
    this.refused.value = [...this.refused.value, refused].slice(-REFUSED_MAX);
  }
}
