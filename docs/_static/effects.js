// Sliders of the catalogue: the paths were simulated when the site was built; a slider chooses among them.
for (const effect of document.querySelectorAll("div.effect")) {
  const steps = JSON.parse(effect.querySelector("script").textContent);
  const lines = effect.querySelectorAll("polyline.moved");
  const slider = effect.querySelector("input");
  slider.addEventListener("input", () => {
    const step = steps[slider.value];
    lines.forEach((line, panel) => line.setAttribute("points", step.points[panel]));
    effect.querySelector("output").textContent = `${step.value}: tip ${step.apart} mm RMS from the declared arm's`;
  });
}
