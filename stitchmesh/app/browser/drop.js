// Files that are dropped anywhere on the page go to the upload of the open page that takes their suffix. A file that is
// too large for the server is refused before it is sent.
(() => {
  if (window.stitchmeshDrop) return;
  const D = { largest: Infinity, receiver: "drop" };
  const inputs = () => [...document.querySelectorAll("input[type=file]")];
  const takes = (input, name) => !input.accept
    || input.accept.split(",").some((suffix) => name.toLowerCase().endsWith(suffix.trim().toLowerCase()));
  const say = (problem, name) => window.stitchmesh.send(D.receiver, { problem, name });

  document.addEventListener("dragover", (event) => event.preventDefault());
  document.addEventListener("drop", (event) => {
    event.preventDefault();
    const file = event.dataTransfer && event.dataTransfer.files[0];
    if (!file) return;
    const input = inputs().find((each) => takes(each, file.name));
    if (!input) return say(inputs().length ? "suffix" : "page", file.name);
    const files = new DataTransfer();
    files.items.add(file);
    input.files = files.files;
    input.dispatchEvent(new Event("change", { bubbles: true }));
  });
  document.addEventListener("change", (event) => {
    const file = event.target.type === "file" && event.target.files && event.target.files[0];
    if (!file || file.size <= D.largest) return;
    event.stopImmediatePropagation();
    event.target.value = "";
    say("size", file.name);
  }, true);
  window.stitchmeshDrop = D;
})();
