// Set the theme before anything is drawn: the user's choice here, else that of the system.
'use strict';
(() => {
  const system = matchMedia('(prefers-color-scheme: dark)');
  const chosen = () => { try { return localStorage.getItem('theme'); } catch { return null; } };
  const apply = () => {
    document.documentElement.dataset.theme = chosen() || (system.matches ? 'dark' : 'light');
    dispatchEvent(new Event('themechange'));
  };
  system.addEventListener('change', apply);
  addEventListener('switchtheme', () => {
    const other = document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark';
    try { localStorage.setItem('theme', other); } catch { /* private windows have no storage */ }
    document.documentElement.dataset.theme = other;
    dispatchEvent(new Event('themechange'));
  });
  apply();
})();
