"""Scripts that find on a page what nobody could read or touch."""

SMALL = """[...document.querySelectorAll('a, button, select, input:not([type=hidden]), summary')]
  .filter(one => !one.classList.contains('skip') && one.type !== 'checkbox' && one.checkVisibility())
  .map(one => [one.textContent, one.getBoundingClientRect()])
  .filter(([_, box]) => box.width > 0 && (box.height < 43.9 || box.width < 30)).map(([text]) => text)"""
CUT = """[...document.querySelectorAll('main *')].filter(one => {
  const style = getComputedStyle(one), box = one.getBoundingClientRect();
  return box.width > 0 && (one.closest('.wide') === null && box.right > innerWidth + 0.5
    || style.overflow === 'hidden' && one.scrollWidth > one.clientWidth + 1);
}).map(one => one.outerHTML.slice(0, 80))"""
OVER = """(() => { const kinds = ['p', 'dd', 'dt', 'li', 'h1', 'h2', 'summary'].map(one => `main ${one}`).join();
  const lines = [...document.querySelectorAll(kinds)]
    .filter(one => one.checkVisibility() && one.getBoundingClientRect().width > 0);
  return lines.filter((one, n) => lines.slice(n + 1).some(other => {
    if (one.contains(other) || other.contains(one)) return false;
    const a = one.getBoundingClientRect(), b = other.getBoundingClientRect();
    return Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1
      && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 1;
  })).map(one => one.textContent.slice(0, 60)); })()"""
"""Texts that stand on one another."""
