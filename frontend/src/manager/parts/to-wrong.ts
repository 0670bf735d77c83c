/** Goes on, once the form is drawn anew, at the first field of it that is wrong: on a telephone it may be out of sight. */
export function toWrong(form: HTMLElement): void {
  requestAnimationFrame(() => { form.querySelector<HTMLElement>("[aria-invalid=true]")?.focus(); });
}
