// One slider moves all films: their frames are in the page, as images.
for (const player of document.querySelectorAll(".player")) {
  const films = JSON.parse(document.getElementById(player.dataset.frames).textContent);
  const slider = player.querySelector("input"), button = player.querySelector("button"), told = player.querySelector("output");
  const show = () => {
    const k = Number(slider.value);
    for (const [name, frames] of Object.entries(films.frames)) document.getElementById(name).src = frames[k];
    told.textContent = films.captions[k];
  };
  let timer = null;
  const stop = () => { clearInterval(timer); timer = null; button.textContent = "play"; };
  button.addEventListener("click", () => {
    if (timer) return stop();
    button.textContent = "stop";
    timer = setInterval(() => { slider.value = (Number(slider.value) + 1) % films.captions.length; show(); }, 120);
  });
  slider.addEventListener("input", show);
  show();
}
