/** How much larger an element is drawn than its style says, on a wall; 1 in browsers that do not tell, which draw none larger. */
export function zoomOf(element: Element): number {
  return (element as { readonly currentCSSZoom?: number }).currentCSSZoom ?? 1;
}
