// @ts-check
/**
 * Keeps STOP in sight where a phone's keyboard covers part of the page.
 */

/** Tells the style sheet what of the page's height is out of sight, above and below [px]. */
export function watchViewport() {
  const seen = window.visualViewport;
  if (!seen) return;
  const page = document.documentElement;

  function measure() {
    if (!seen) return;
    const below = page.clientHeight - seen.offsetTop - seen.height;
    page.style.setProperty("--unseen-above", `${Math.max(0, seen.offsetTop)}px`);
    page.style.setProperty("--unseen-below", `${Math.max(0, below)}px`);
  }

  seen.addEventListener("resize", measure);
  seen.addEventListener("scroll", measure);
  measure();
}
