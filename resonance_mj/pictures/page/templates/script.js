// The page is whole without this: copying, going to a scene, and opening what is folded for paper.
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
const folded = () => document.querySelectorAll("details:not([open])");
let opened = [];
addEventListener("beforeprint", () => {
  opened = [...folded()];
  for (const details of opened) details.open = true;
});
addEventListener("afterprint", () => {
  for (const details of opened) details.open = false;
});
