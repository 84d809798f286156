// The page is whole without this: copying, going to a scene, values of curves under the pointer, and opening what
// is folded for paper.
for (const button of document.querySelectorAll("button.copy")) {
  const text = document.getElementById(button.dataset.copy);
  button.hidden = false;
  button.addEventListener("click", async () => {
    try {
      await navigator.clipboard.writeText(text.innerText);
    } catch {
      getSelection().selectAllChildren(text);
      document.execCommand("copy");
    }
    button.textContent = "Copied";
    setTimeout(() => (button.textContent = "Copy"), 1500);
  });
}
for (const scenes of document.querySelectorAll(".scenes")) {
  const video = scenes.parentElement.querySelector("video");
  scenes.hidden = false;
  scenes.addEventListener("click", ({ target }) => {
    if (target.dataset.at === undefined) return;
    // A little into the frame, so that rounding does not show the one before.
    video.currentTime = Number(target.dataset.at) + 0.01;
  });
}
const SVG = "http://www.w3.org/2000/svg";
const NEAR = 14;
/** The corners of a curve as the SVG has them, one list for each of its pieces. */
const corners = (id) => [...document.getElementById(id)?.querySelectorAll(":scope > path") ?? []].flatMap((path) =>
  path.getAttribute("d").split("M").slice(1).map((piece) => piece.split("L").map((pair) => pair.trim().split(/[\s,]+/).map(Number))));
const along = ([low, high, logarithmic], share) =>
  logarithmic ? low * (high / low) ** share : low + (high - low) * share;
const unit = (words) => words.match(/ \[(.*)\]$/)?.[1].replace(/^1$/, "") ?? "";
const reading = (value) => Number(value.toPrecision(4)).toString().replace("-", "−");
for (const svg of document.querySelectorAll("svg[data-panels]")) {
  const panels = JSON.parse(svg.dataset.panels), shown = document.createElementNS(SVG, "g");
  shown.setAttribute("class", "reading");
  shown.innerHTML = "<circle r='2'/><text class='halo'/><text/>";
  shown.setAttribute("visibility", "hidden");
  svg.append(shown);
  const [dot, ...words] = shown.children;
  const nearest = (panel, at) => {
    panel.pieces ??= Object.entries(panel.curves).flatMap(([id, name]) => corners(id).map((points) => ({ name, points })));
    let best = { off: NEAR };
    for (const { name, points } of panel.pieces) {
      for (let i = 1; i < points.length; i++) {
        const [[a, b], [c, d]] = [points[i - 1], points[i]], square = (c - a) ** 2 + (d - b) ** 2;
        let part = square && Math.min(1, Math.max(0, ((at.x - a) * (c - a) + (at.y - b) * (d - b)) / square));
        if (panel.of === "cycle") part = Math.round(part);  // between two cycles there is no value
        const x = a + part * (c - a), y = b + part * (d - b), off = Math.hypot(at.x - x, at.y - y);
        if (off < best.off) best = { off, x, y, name };
      }
    }
    return best;
  };
  svg.addEventListener("pointermove", (event) => {
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    const panel = panels.find(({ box: [left, right, top, bottom] }) => at.x >= left && at.x <= right && at.y >= top && at.y <= bottom);
    const found = panel && nearest(panel, at);
    shown.setAttribute("visibility", found?.name === undefined ? "hidden" : "visible");
    if (found?.name === undefined) return;
    const [left, right, top, bottom] = panel.box, share = (found.x - left) / (right - left);
    const y = along(panel.y, (bottom - found.y) / (bottom - top));
    let x = along(panel.x, share);
    const piece = panel.times.find(([, , from, to]) => x >= from && x <= to);
    if (piece) x = piece[0] + ((x - piece[2]) / (piece[3] - piece[2])) * (piece[1] - piece[0]);
    const where = panel.of === "cycle" ? `cycle ${reading(x)}` : `${reading(x)} ${unit(panel.of)}`;
    const said = `${found.name ? `${found.name}: ` : ""}${reading(y)} ${unit(panel.title)} at ${where}`;
    dot.setAttribute("cx", found.x);
    dot.setAttribute("cy", found.y);
    for (const text of words) {
      text.textContent = said;
      text.setAttribute("x", found.x);
      text.setAttribute("y", found.y < top + 14 ? found.y + 13 : found.y - 6);
      text.setAttribute("text-anchor", share > 0.5 ? "end" : "start");
    }
  });
  svg.addEventListener("pointerleave", () => shown.setAttribute("visibility", "hidden"));
}
const folded = () => document.querySelectorAll("details:not([open])");
let opened = [];
addEventListener("beforeprint", () => {
  opened = [...folded()];
  for (const details of opened) details.open = true;
});
addEventListener("afterprint", () => {
  for (const details of opened) details.open = false;
});
