// Addresses of panels: #/ID?key=value&beside=ID2,ID3&ID2.key=value shows the panel ID, and up to three beside it if the
// screen is wide enough. The keys `ID2.key` belong to the panel ID2, all others except `beside` to ID.

export const MOST_BESIDE = 3;

// Return {id, parameters} of an address's part after the #.
export function parseAddress(hash) {
  const [path, query = ''] = hash.replace(/^#\/?/, '').split('?');
  return {id: decode(path), parameters: Object.fromEntries(new URLSearchParams(query))};
}

// Return the address of a panel; parameters that are '' or null are left out.
export function addressOf(id, parameters = {}) {
  const given = Object.entries(parameters).filter(([, value]) => value !== '' && value !== null && value !== undefined);
  const query = String(new URLSearchParams(given)).replace(/%2C/g, ','); // readable
  return `#/${id}${query ? `?${query}` : ''}`;
}

// Return the ids of the panels beside `id`.
export function besideOf(id, parameters) {
  const listed = (parameters.beside ?? '').split(',').filter((panel) => panel && panel !== id);
  return [...new Set(listed)].slice(0, MOST_BESIDE);
}

// Return the parameters of an address that belong to its first panel, or to the panel `id` beside it.
export function ownParameters(parameters, id = '') {
  const own = Object.entries(parameters).filter(([key]) => (id ? key.startsWith(`${id}.`) : key !== 'beside' && !key.includes('.')));
  return Object.fromEntries(own.map(([key, value]) => [id ? key.slice(id.length + 1) : key, value]));
}

// Return `beside` and the parameters of the panels beside the first one; `ids`: of those that remain.
export function besideParameters(parameters, ids) {
  const kept = Object.entries(parameters).filter(([key]) => ids.includes(key.split('.')[0]) && key.includes('.'));
  return {...Object.fromEntries(kept), beside: ids.join(',')};
}

// Return the address of the page without the token, which a cookie keeps: the address bar is what a projector shows.
export function withoutToken(address) {
  const url = new URL(address);
  url.searchParams.delete('token');
  return url.href;
}

function decode(text) {
  try {
    return decodeURIComponent(text);
  } catch {
    return text;
  }
}
