"use strict";
/* Starts the viewer of a page that contains its meshes. */

for (const root of document.querySelectorAll("[data-viewer]")) {
  const header = root.querySelector("[data-scene-header]"), body = root.querySelector("[data-scene-body]");
  (async () => {
    const viewer = new Viewer(root);
    viewer.show(await readScene(JSON.parse(header.textContent), bytesOf(body.textContent)));
    connect(viewer, root.querySelector("form"));
    for (const button of root.querySelectorAll("[data-approach]")) {
      button.addEventListener("click", () => {
        viewer.approach(viewer.scene.markers[Number(button.dataset.approach)].place, 12);
        viewer.canvas.focus();
      });
    }
    root.dataset.ready = "yes";
  })().catch((error) => {
    const problem = root.querySelector("[data-problem]");
    problem.textContent = error.message;
    problem.hidden = false;
  });
}
