// Commands name the folder that the page lies in, wherever it was written or moved to.
function located(command) {
  if (location.protocol !== "file:") return command;
  const written = document.body.dataset.folder;
  const here = decodeURIComponent(location.pathname).replace(/\/[^/]*$/, "");
  const quoted = (path) => /^[\w.\/+@-]+$/.test(path) ? path : "'" + path.replaceAll("'", "'\\''") + "'";
  const place = (word) => word === written || word.startsWith(written + "/") ? quoted(here + word.slice(written.length)) : word;
  return command.split(" ").map(place).join(" ");
}
document.querySelectorAll("button.command").forEach(function (button) {
  button.title = button.dataset.command = located(button.dataset.command);
});
document.querySelectorAll("pre.located").forEach((shown) => { shown.textContent = located(shown.textContent); });
