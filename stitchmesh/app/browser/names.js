// Names for screen readers and darker letters: viser leaves some of its inputs and icons without a name, and some of its
// letters too pale to be read. Settings that serve no user are hidden.
(() => {
  if (document.getElementById("stitchmesh-letters")) return;
  const style = document.createElement("style");
  style.id = "stitchmesh-letters";
  style.textContent = `
    .mantine-Flex-root label[for], .mantine-Input-label { color: var(--mantine-color-text) !important; }
    [data-mantine-color-scheme=light] .mantine-Button-root[data-variant=outline] .mantine-Button-label
      { color: #1f5673 !important; }
    [data-mantine-color-scheme=dark] .mantine-Button-root[data-variant=outline] .mantine-Button-label
      { color: #9fd0ea !important; }`;
  document.head.append(style);

  const icons = { adjustments: "Settings of the view", "list-search": "All commands", "chevrons-right": "Hide the panel",
    "chevrons-left": "Show the panel", x: "Close", "arrow-back": "Back" };
  const named = (element) => element.getAttribute("aria-label") || element.getAttribute("aria-labelledby")
    || element.title || element.textContent.trim();
  const iconName = (button) => {
    const icon = button.querySelector("svg[class*=tabler-icon-]");
    const found = icon && /tabler-icon-([a-z0-9-]+)/.exec(icon.getAttribute("class"));
    return found ? icons[found[1]] || found[1].replaceAll("-", " ") : "Button";
  };
  const nameAll = () => {
    for (const label of document.querySelectorAll(".mantine-Flex-root label")) {
      const row = label.closest(".mantine-Flex-root");
      for (const input of row.querySelectorAll("input:not([type=hidden]), textarea, [role=slider]")) {
        if (input.id !== label.htmlFor && !input.getAttribute("aria-label")) {
          input.setAttribute("aria-label", label.textContent.trim());
        }
      }
    }
    for (const label of document.querySelectorAll(".mantine-Checkbox-label")) {  // They are those of viser's authors.
      if (label.textContent === "Dev Settings") label.closest(".mantine-Checkbox-root").style.display = "none";
    }
    for (const button of document.querySelectorAll("button")) {
      if (!named(button)) button.setAttribute("aria-label", iconName(button));
    }
  };
  let waiting = false;
  const later = () => {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => {
      waiting = false;
      nameAll();
    });
  };
  new MutationObserver(later).observe(document.body, { childList: true, subtree: true });
  later();
})();
