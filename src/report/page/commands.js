// Text as one word of a command line.
function quoted(text) { return /^[\w.\/+@,-]+$/.test(text) ? text : "'" + text.replaceAll("'", "'\\''") + "'"; }

// Commands name the folder that the page lies in, wherever it was written or moved to.
function located(command) {
  if (location.protocol !== "file:") return command;
  const written = document.body.dataset.folder;
  const here = decodeURIComponent(location.pathname).replace(/\/[^/]*$/, "");
  return command.replace(/(?:'[^']*'|\\.|[^\s'\\])+/g, function (word) {
    const plain = word.replace(/'([^']*)'|\\(.)/g, "$1$2");
    return plain === written || plain.startsWith(written + "/") ? quoted(here + plain.slice(written.length)) : word;
  });
}
document.querySelectorAll("button.command").forEach(function (button) {
  button.title = button.dataset.command = located(button.dataset.command);
});
document.querySelectorAll("pre.located").forEach((shown) => { shown.textContent = located(shown.textContent); });
