// Addresses of panels: #/ID?key=value&beside=ID2 shows the panel ID, and ID2 beside it if the screen is wide enough. All
// keys except `beside` belong to the panel ID.

// Return {id, parameters} of an address's part after the #.
export function parseAddress(hash) {
  const [path, query = ''] = hash.replace(/^#\/?/, '').split('?');
  return {id: decode(path), parameters: Object.fromEntries(new URLSearchParams(query))};
}

// Return the address of a panel; parameters that are '' or null are left out.
export function addressOf(id, parameters = {}) {
  const given = Object.entries(parameters).filter(([, value]) => value !== '' && value !== null && value !== undefined);
  const query = String(new URLSearchParams(given));
  return `#/${id}${query ? `?${query}` : ''}`;
}

function decode(text) {
  try {
    return decodeURIComponent(text);
  } catch {
    return text;
  }
}
