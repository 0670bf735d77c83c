// Runs before the first paint, as a plain script: it imports nothing, so that it stays one small file.
try {
  const theme = localStorage.getItem("dray.theme");
  if (theme === "light" || theme === "dark" || theme === "paper") document.documentElement.dataset.theme = theme;
} catch {
  // Without memory the system's theme holds.
}
