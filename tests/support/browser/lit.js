const figure = document.querySelector(`figure[data-what=${arguments[0]}]`);
return [...new Set([...figure.querySelectorAll("[data-id].lit")].map((e) => e.dataset.id.replace(/^slot\./, "op.")))].sort();
