// Typed fields of topics: /turtle1/pose/x, /turtle1/pose/x:y as in rqt_plot, several with commas or spaces.
import {parsePath} from './values.js';

// Return the single fields in a text.
export function expand(text) {
  return text.split(/[\s,]+/).filter(Boolean).flatMap((typed) => {
    const [first, ...others] = typed.replace(/\/+/g, '/').split(':');
    const path = first.startsWith('/') ? first : `/${first}`;
    const folder = path.slice(0, path.lastIndexOf('/') + 1);
    return [path, ...others.filter(Boolean).map((name) => (name.startsWith('/') ? name : folder + name))]
      .map((field) => field.replace(/(.)\/$/, '$1'));
  });
}

// Return {topic, path}: the longest of the topics that a field begins with, and the rest of it; null without one.
export function split(field, topics) {
  let found = null;
  for (const topic of topics) {
    if ((field === topic || field.startsWith(`${topic}/`)) && (!found || topic.length > found.length)) found = topic;
  }
  return found === null ? null : {topic: found, path: field.slice(found.length + 1)};
}

// Return the paths of the numbers at a path of a message: the path itself, or all numbers of the message there. Throw an
// Error that lists the numbers.
export function numbersAt(types, path) {
  const all = types.numericPaths();
  const parts = parsePath(path);
  if (parts === null) throw new Error(`"${path}" is not a field. Fields look like pose/position/x or ranges[0].`);
  if (path === '') {
    if (!all.length) throw new Error(`${types.root} has no numbers to plot.`);
    return all;
  }
  if (isNumber(types, parts)) return [path];
  const below = all.filter((number) => number.startsWith(`${path}/`) || number.startsWith(`${path}[`));
  if (below.length) return below;
  throw new Error(`${types.root} has no number "${path}". It has ${all.slice(0, 12).join(', ')}`
                  + `${all.length > 12 ? ` and ${all.length - 12} more` : ''}.`);
}

function isNumber(types, parts) {
  let type = types.root;
  let array = null;
  for (const part of parts) {
    if (typeof part === 'number') {
      if (array === null || (array > 0 && part >= array)) return false;
      array = null;
      continue;
    }
    const field = array === null && types.fieldsOf(type).find(({name}) => name === part);
    if (!field) return false;
    ({type, array} = field);
  }
  return array === null && types.isPrimitive(type) && type !== 'string';
}
