'use strict';
const all = (selector, root = document) => [...root.querySelectorAll(selector)];
const table = document.querySelector('.table table'), form = document.querySelector('form');
form.hidden = false;
const filter = () => {
  const name = form.elements.name.value.trim().toLowerCase(), exercise = form.elements.exercise.value;
  const verdicts = all('[name=verdict]:checked', form).map(box => box.value);
  const fits = element => (!exercise || element.dataset.exercise === exercise)
    && verdicts.includes(element.dataset.verdict);
  all('[data-column]', table).forEach(cell => { cell.hidden = exercise && cell.dataset.exercise !== exercise; });
  for (const row of table.tBodies[0].rows)
    row.hidden = !row.dataset.student.toLowerCase().includes(name) || !all('td[data-column]', row).some(fits);
  all('.submission').forEach(part => {
    part.hidden = !part.dataset.student.toLowerCase().includes(name) || !fits(part);
  });
};
form.addEventListener('input', filter);
form.addEventListener('submit', event => event.preventDefault());
form.addEventListener('reset', () => setTimeout(filter));
all('thead button', table).forEach(button => button.addEventListener('click', () => {
  const head = button.closest('th'), column = head.cellIndex;
  const up = head.getAttribute('aria-sort') === (column ? 'descending' : 'ascending') ? column : !column;
  all('thead th', table).forEach(other => other.removeAttribute('aria-sort'));
  head.setAttribute('aria-sort', up ? 'ascending' : 'descending');
  const value = row => row.cells[column].dataset.value ?? row.dataset.student;
  const order = (a, b) => column ? value(a) - value(b) : value(a).localeCompare(value(b));
  table.tBodies[0].append(...[...table.tBodies[0].rows].sort((a, b) => up ? order(a, b) : order(b, a)));
}));
const show = () => {
  const part = location.hash && document.getElementById(decodeURIComponent(location.hash.slice(1)));
  if (part) { part.hidden = false; part.open = true; part.scrollIntoView(); }
};
addEventListener('hashchange', show);
all('td a', table).forEach(link => link.addEventListener('click', () => setTimeout(show)));
document.getElementById('all').addEventListener('click', event => {
  const parts = all('.submission'), open = parts.some(part => !part.open);
  parts.forEach(part => { part.open = open; });
});
show();
