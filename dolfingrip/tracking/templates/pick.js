"use strict";
const [frame, image, done, said] = ["frame", "image", "done", "said"].map((id) => document.getElementById(id));
const points = [];
const shown = () => {
  frame.querySelectorAll(".ring").forEach((ring) => ring.remove());
  points.forEach(([u, v], i) => {
    const ring = document.createElement("button");
    ring.className = "ring";
    ring.setAttribute("aria-label", `dot ${i + 1}: take it away`);
    ring.style.left = `${(100 * (u + 0.5)) / image.naturalWidth}%`;
    ring.style.top = `${(100 * (v + 0.5)) / image.naturalHeight}%`;
    ring.onclick = () => { points.splice(i, 1); shown(); };
    frame.append(ring);
  });
  said.textContent = `${points.length} dots`;
  done.disabled = points.length < {{ least }};
};
image.onclick = (event) => {
  const box = image.getBoundingClientRect();
  points.push([
    ((event.clientX - box.left) * image.naturalWidth) / box.width - 0.5,
    ((event.clientY - box.top) * image.naturalHeight) / box.height - 0.5,
  ]);
  shown();
};
done.onclick = async () => {
  const answer = await fetch("/dots", { method: "POST", body: JSON.stringify(points) });
  said.textContent = await answer.text();
  done.disabled = answer.ok;
};
