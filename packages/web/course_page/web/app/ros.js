// A client of rosbridge protocol 2: topics, services, and recovery when the connection or the master is lost.
//
// The whole page uses one WebSocket. All subscriptions to a topic share one on the wire, at the highest requested rate;
// each gets messages at most as often as it has asked for. A lost connection is opened again, with all its
// subscriptions. Publishers advertise again with their next message.

const RETRY = 500;              // [ms] until the next try to connect
const STATUS_PERIOD = 1000;     // [ms] between two requests of the server's /status
const STALL = 2000;             // [ms] without anything from the server, after which the connection counts as stalled
const STATUS_TIMEOUT = 3000;    // [ms]
const CALL_TIMEOUT = 10000;     // [ms] for the answer of a service
const ADVERTISED = 60000;       // [ms] without a message, after which a topic is unadvertised

export class Ros {
  // `state.link`: 'connecting' (the first time), 'open', or 'lost' (reconnecting). `state.master`: whether a ROS master
  // answers; `state.uri`: its address; `state.server`: whether the page's server answers; `state.stalled`: whether an open
  // link is silent. `driving`: {topic: number of pages and other clients of this server that drive}, `node`: its name.
  constructor(address = addressFor(location.href)) {
    this.address = address;
    this.state = {link: 'connecting', master: true, server: true, uri: '', stalled: false};
    this.driving = {};
    this.node = '';
    this._heard = this._listened = performance.now();
    this.statuses = new Set();    // functions that get the server's reports: {level, text}
    this._states = new Set();
    this._topics = new Map();     // name: {type, listeners, asked, last}
    this._published = new Map();  // name: {type, timer}
    this._calls = new Map();      // id: {resolve, reject, timer}
    this._next = 0;
    this._hooks = new Set();
    this._connect();
    this._watch();
    setInterval(() => this._listen(), STALL / 4);
    document.addEventListener('visibilitychange', () => {
      this._hear();
      if (!document.hidden) this._poll();
    });
  }

  get connected() {
    return this.state.link === 'open' && this.state.master;
  }

  // Call `callback(state)` now and at each change; return a function that ends it.
  onState(callback) {
    this._states.add(callback);
    callback(this.state);
    return () => this._states.delete(callback);
  }

  // Call `callback()` each time a connection opens, before anything else is sent; return a function that ends it.
  onOpen(callback) {
    this._hooks.add(callback);
    if (this.state.link === 'open') callback();
    return () => this._hooks.delete(callback);
  }

  // Call `callback(message)` for the messages of a topic, at most `rate` times a second (0: all); return a function that
  // ends it. `length`: how many messages may wait on a slow connection; with it, newer ones replace none of them.
  // A later subscriber gets the last message at once, if there was one.
  subscribe(name, type, callback, {rate = 0, compression = 'none', length = 0} = {}) {
    let topic = this._topics.get(name);
    if (!topic) this._topics.set(name, topic = {type, listeners: new Set(), sent: '', last: undefined});
    const listener = {callback, rate, compression, length, due: 0};
    topic.listeners.add(listener);
    if (topic.last !== undefined) {
      queueMicrotask(() => topic.listeners.has(listener) && listener.callback(topic.last));
    }
    this._ask(name, topic);
    return () => {
      if (!topic.listeners.delete(listener)) return;
      if (topic.listeners.size) {
        this._ask(name, topic);
      } else {
        this._topics.delete(name);
        this.send({op: 'unsubscribe', id: `page:${name}`, topic: name});
      }
    };
  }

  // Publish a message; return whether it was sent.
  publish(name, type, message) {
    if (this.state.link !== 'open') return false;
    let published = this._published.get(name);
    if (!published || published.type !== type) {
      this._published.set(name, published = {type});
      this.send({op: 'advertise', id: `page:${name}`, topic: name, type});
    }
    clearTimeout(published.timer);
    published.timer = setTimeout(() => {
      this._published.delete(name);
      this.send({op: 'unadvertise', id: `page:${name}`, topic: name});
    }, ADVERTISED);
    return this.send({op: 'publish', topic: name, msg: message});
  }

  // Call a service; return a Promise of its response, or reject it with an Error that says why.
  call(service, args = {}, {timeout = CALL_TIMEOUT, type} = {}) {
    const id = `call:${++this._next}`;
    return new Promise((resolve, reject) => {
      if (!this.send({op: 'call_service', id, service, args, type})) {
        reject(new Error(`${service} cannot be called: there is no connection to ROS`));
        return;
      }
      const timer = setTimeout(() => {
        this._calls.delete(id);
        reject(new Error(`${service} has not answered within ${timeout / 1000} s`));
      }, timeout);
      this._calls.set(id, {resolve, reject, timer});
    });
  }

  // Send an operation of the protocol; return whether there is a connection.
  send(operation) {
    if (this._socket?.readyState !== WebSocket.OPEN) return false;
    this._socket.send(JSON.stringify(operation));
    return true;
  }

  _connect() {
    const socket = this._socket = new WebSocket(this.address);
    socket.onopen = () => {
      this._published.clear();
      for (const hook of this._hooks) hook();
      for (const [name, topic] of this._topics) {
        topic.sent = '';
        this._ask(name, topic);
      }
      this._hear();
      this._set({link: 'open', server: true, master: true});
      this._poll();
    };
    socket.onmessage = (event) => {
      this._hear();
      this._received(event.data);
    };
    socket.onclose = () => {
      for (const {reject, timer} of this._calls.values()) {
        clearTimeout(timer);
        reject(new Error('the connection was lost before the answer came'));
      }
      this._calls.clear();
      if (this.state.link === 'open') this._set({link: 'lost'});
      setTimeout(() => this._connectAgain(), RETRY);
    };
  }

  // Connect as soon as the server says that it is ready.
  async _connectAgain() {
    await this._poll();
    if (this.state.server && this._ready) this._connect();
    else setTimeout(() => this._connectAgain(), RETRY);
  }

  _ask(name, topic) {
    const listeners = [...topic.listeners];
    const rate = listeners.some((listener) => !listener.rate) ? 0 : Math.max(...listeners.map((listener) => listener.rate));
    const operation = {
      op: 'subscribe', id: `page:${name}`, topic: name, throttle_rate: rate ? Math.round(1000 / rate) : 0,
      queue_length: Math.max(...listeners.map(({length}) => length)), compression: listeners[0].compression,
      ...(topic.type ? {type: topic.type} : {}),
    };
    const frame = JSON.stringify(operation);
    if (frame !== topic.sent && this.send(operation)) topic.sent = frame;
  }

  _received(data) {
    if (typeof data !== 'string') return;
    const operation = JSON.parse(data);
    if (operation.op === 'publish') {
      this._deliver(operation.topic, operation.msg);
    } else if (operation.op === 'service_response') {
      const call = this._calls.get(operation.id);
      if (!call) return;
      this._calls.delete(operation.id);
      clearTimeout(call.timer);
      if (operation.result) call.resolve(operation.values);
      else call.reject(new Error(String(operation.values)));
    } else if (operation.op === 'status') {
      for (const callback of this.statuses) callback({level: operation.level, text: String(operation.msg)});
    }
  }

  _deliver(name, message) {
    const topic = this._topics.get(name);
    if (!topic) return;
    topic.last = message;
    const now = performance.now();
    for (const listener of topic.listeners) {
      if (listener.rate) {
        if (now < listener.due - 2) continue;  // [ms] timers are not exact
        listener.due = Math.max(listener.due, now - 1000 / listener.rate) + 1000 / listener.rate;
      }
      listener.callback(message);
    }
  }

  _set(changes) {
    const before = JSON.stringify(this.state);
    Object.assign(this.state, changes);
    if (JSON.stringify(this.state) !== before) {
      for (const callback of [...this._states]) callback(this.state);
    }
  }

  _hear() {
    this._heard = performance.now();
    if (this.state.stalled) this._set({stalled: false});
  }

  // Note a silent link. A page that was busy itself has not listened.
  _listen() {
    const now = performance.now();
    if (now - this._listened > STALL / 2) this._heard = now;
    this._listened = now;
    this._set({stalled: this.state.link === 'open' && !document.hidden && now - this._heard > STALL});
  }

  async _watch() {
    for (;;) {
      const pause = new Promise((resolve) => setTimeout(resolve, STATUS_PERIOD));
      if (!document.hidden) await this._poll();
      await pause;
    }
  }

  // Ask the server for the state of the master. A server without /status is another rosbridge, which has a master.
  async _poll() {
    if (this._polling) return;
    this._polling = true;
    try {
      const answer = await fetch('status', {signal: AbortSignal.timeout(STATUS_TIMEOUT)});
      const found = answer.ok ? await answer.json() : {master: true, ready: true, uri: ''};
      this._ready = found.ready;
      this.driving = found.driving ?? {};
      this.node = found.name ?? '';
      this._hear();
      this._set({server: true, master: Boolean(found.master), uri: String(found.uri)});
    } catch {
      if (this.state.link !== 'open') this._set({server: false});
    } finally {
      this._polling = false;
    }
  }
}

// Return the WebSocket's address for a page: that of its folder, which is not the root behind some proxies.
export function addressFor(page) {
  return new URL('./', page).href.replace(/^http/, 'ws');
}
