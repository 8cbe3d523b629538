// The fields of messages and services, from rosapi.

const PRIMITIVES = new Set(['bool', 'byte', 'char', 'int8', 'uint8', 'int16', 'uint16', 'int32', 'uint32', 'int64',
                            'uint64', 'float32', 'float64', 'string', 'time', 'duration']);
const SINGLE = -1; // rosapi's fieldarraylen of a field that is not an array
const caches = new WeakMap(); // of a connection: {request: promise}

// The types in a message or a part of a service; `root` is the outermost one.
export class Types {
  constructor(typedefs) {
    this._typedefs = new Map(typedefs.map((typedef) => [typedef.type, typedef]));
    this._fields = new Map();
    this.root = typedefs.length ? typedefs[0].type : '';
  }

  // Return the fields of a type: {name, type, array}; `array` is null, 0 for any length, or the length.
  fieldsOf(type = this.root) {
    if (!this._fields.has(type)) {
      const typedef = this._typedefs.get(type);
      this._fields.set(type, !typedef ? [] : typedef.fieldnames.map((name, i) => ({
        name, type: typedef.fieldtypes[i],
        array: typedef.fieldarraylen[i] === SINGLE ? null : typedef.fieldarraylen[i]})));
    }
    return this._fields.get(type);
  }

  // Return the constants of a type: [name, value].
  constantsOf(type = this.root) {
    const typedef = this._typedefs.get(type);
    return !typedef || !typedef.constnames ? [] : typedef.constnames.map((name, i) => [name, typedef.constvalues[i]]);
  }

  isPrimitive(type) {
    return PRIMITIVES.has(type);
  }

  // Return the paths of all fields that can be plotted, such as 'pose/position/x'; of arrays the first element.
  numericPaths(type = this.root, depth = 0) {
    if (depth > 8) return [];
    return this.fieldsOf(type).flatMap(({name, type: kind, array}) => {
      if (array === 0 && PRIMITIVES.has(kind)) return kind === 'string' ? [] : [`${name}[0]`];
      if (array !== null) {
        if (array === 0 || kind === 'string' || !PRIMITIVES.has(kind)) return [];
        return Array.from({length: Math.min(array, 36)}, (_, i) => `${name}[${i}]`);
      }
      if (kind === 'string') return [];
      if (PRIMITIVES.has(kind)) return [name];
      return this.numericPaths(kind, depth + 1).map((path) => `${name}/${path}`);
    });
  }
}

function cached(ros, key, load) {
  if (!caches.has(ros)) caches.set(ros, new Map());
  const cache = caches.get(ros);
  if (!cache.has(key)) {
    const promise = load();
    cache.set(key, promise);
    promise.catch(() => cache.delete(key));
  }
  return cache.get(key);
}

// Return the Types of a message type; raise an Error if it is not known there.
export function messageTypes(ros, type) {
  return cached(ros, `message ${type}`, async () => {
    const {typedefs} = await ros.call('/rosapi/message_details', {type});
    if (!typedefs.length) {
      throw new Error(`The message type ${type} is not installed where the bridge runs. Build its package there, `
                      + 'then start the bridge again.');
    }
    return new Types(typedefs);
  });
}

// Return {type, request, response} of a service: its type's name, and the Types of both parts.
export async function serviceTypes(ros, service) {
  const {type} = await ros.call('/rosapi/service_type', {service});
  if (!type) throw new Error(`The service ${service} does not report its type: its node may have ended.`);
  return cached(ros, `service ${type}`, async () => {
    const [request, response] = await Promise.all([
      ros.call('/rosapi/service_request_details', {type}), ros.call('/rosapi/service_response_details', {type})]);
    if (!request.typedefs.length) {
      throw new Error(`The service type ${type} is not installed where the bridge runs. Build its package there, `
                      + 'then start the bridge again.');
    }
    return {type, request: new Types(request.typedefs), response: new Types(response.typedefs)};
  });
}
