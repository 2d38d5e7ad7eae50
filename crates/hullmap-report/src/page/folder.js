{
  const cards = [...document.querySelectorAll("#packs > li")];
  const text = document.getElementById("filter");
  const onlyOdd = document.getElementById("only-odd");
  const found = document.getElementById("found");
  const update = () => {
    const wanted = text.value.trim().toLowerCase();
    let count = 0;
    for (const card of cards) {
      const fits = card.dataset.name.toLowerCase().includes(wanted) && (!onlyOdd.checked || card.dataset.odd === "true");
      card.hidden = !fits;
      count += fits ? 1 : 0;
    }
    found.textContent = `${count} of ${cards.length}`;
  };
  text.addEventListener("input", update);
  onlyOdd.addEventListener("change", update);
  update();
  const images = [...document.images];
  const check = () => {
    document.documentElement.dataset.pictures = images.filter((image) => image.naturalWidth > 0).length;
    document.documentElement.dataset.ready = "true";
  };
  Promise.all(images.map((image) => image.decode().catch(() => {}))).then(check);
}
