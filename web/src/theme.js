// Light or dark: the reader's choice; a page from a file may have no memory for it.

const root = document.documentElement;
const KEY = 'dolfingrip-theme';
const NEXT = { auto: 'light', light: 'dark', dark: 'auto' };
const SIGN = { auto: '◐ Auto', light: '☀ Light', dark: '☾ Dark' };

/** Wire the button; the function that is returned applies the choice to views that came later. */
export function themes(views) {
  const system = matchMedia('(prefers-color-scheme: dark)');
  const button = document.getElementById('theme');
  let choice = 'auto';
  try {
    choice = localStorage.getItem(KEY) ?? 'auto';
  } catch {
    // no memory: the system's choice
  }
  const apply = () => {
    const dark = choice === 'dark' || (choice === 'auto' && system.matches);
    root.dataset.theme = dark ? 'dark' : 'light';
    button.textContent = SIGN[choice] ?? SIGN.auto;
    for (const view of views) view.setTheme(dark);
  };
  button.addEventListener('click', () => {
    choice = NEXT[choice] ?? 'auto';
    try {
      localStorage.setItem(KEY, choice);
    } catch {
      // this page alone
    }
    apply();
  });
  system.addEventListener('change', apply);
  apply();
  return apply;
}
