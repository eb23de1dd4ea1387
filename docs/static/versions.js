// A choice of versions, where the page stands in a site that has several (setup/site.py).
document.addEventListener("DOMContentLoaded", async () => {
  const root = new URL(document.documentElement.dataset.content_root, location.href);
  const site = new URL("..", root);
  const answer = await fetch(new URL("versions.json", site)).catch(() => null);
  const brand = document.querySelector(".sidebar-brand");
  if (!answer?.ok || !brand) return;
  const here = root.pathname.split("/").at(-2);
  const choice = document.createElement("select");
  choice.setAttribute("aria-label", "version");
  for (const name of await answer.json()) choice.add(new Option(name, name, false, name === here));
  choice.onchange = () => location.assign(new URL(`${choice.value}/`, site));
  brand.after(choice);
});
