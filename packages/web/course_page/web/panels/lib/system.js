// Publishers, subscribers and servers of all nodes, kept up to date while a panel shows them.

const POLL_INTERVAL = 0.5; // s
const SHARE = 0.1; // of the time that polling may take
const NEW = 5000; // ms in which a new node may still create topics
const IN_TURN = 4; // old nodes that are queried again at each poll

const DEBUG_NODES = /^\/(rosout|browser|rosapi|rosbridge_websocket|web_video_server|tf2_web_republisher)$|^\/(rostopic|rosservice|rqt|record|play)_/;
const DEBUG_TOPICS = /^\/(rosout|rosout_agg|clock|statistics|client_count|connected_clients|tf|tf_static)$|\/parameter_(updates|descriptions)$/;

// Nodes of tools, not of users.
export function isDebugNode(name) {
  return DEBUG_NODES.test(name);
}

function isDebugTopic(name) {
  return DEBUG_TOPICS.test(name);
}

// Calls `changed(system)` first and after each change, with {nodes: Map name -> {publishing, subscribing, services},
// types: Map topic -> type}.
export class System {
  constructor(scope, rosapi, changed, failed) {
    this.nodes = new Map();
    this.types = new Map();
    this._rosapi = rosapi;
    this._changed = changed;
    this._seen = new Map(); // node: when it appeared
    this._turn = 0;
    this._last = '';
    this._due = 0;
    this.poll = scope.every(POLL_INTERVAL, () => this._poll(scope), failed);
  }

  async _poll(scope) {
    const start = performance.now();
    if (start < this._due) return;
    const [names, topics] = await Promise.all([this._rosapi.nodes(), this._rosapi.topics()]);
    const types = new Map(topics.map(({name, type}) => [name, type]));
    const others = types.size !== this.types.size || topics.some(({name}) => !this.types.has(name));
    for (const name of names) if (!this._seen.has(name)) this._seen.set(name, this._last ? start : -NEW);
    for (const name of [...this._seen.keys()]) {
      if (!names.includes(name)) {
        this._seen.delete(name);
        this.nodes.delete(name);
      }
    }
    this._turn = (this._turn + IN_TURN) % Math.max(1, names.length);
    const queried = names.filter((name, i) => others || !this.nodes.has(name) || start - this._seen.get(name) < NEW
      || (i - this._turn + names.length) % names.length < IN_TURN);
    await Promise.all(queried.map(async (name) => {
      const {publishing, subscribing, services} = await this._rosapi.nodeDetails(name);
      if (this._seen.has(name)) this.nodes.set(name, {publishing, subscribing, services});
    }));
    this.types = types;
    this._due = performance.now() + (performance.now() - start) * (1 / SHARE - 1);
    const now = JSON.stringify([[...this.nodes].sort(([a], [b]) => (a < b ? -1 : 1)), [...types]]);
    if (now !== this._last && !scope.ended) {
      this._last = now;
      this._changed(this);
    }
  }
}

// Return the graph to draw of a system: {nodes: [name], topics: [name], edges: [[from, to, label]]}, where from and to
// are 'n:NAME' and 't:NAME'. `options`: {debug, topics, loose, filter}.
export function graphOf(system, {debug = false, topics = true, loose = true, filter = ''} = {}) {
  const nodes = [...system.nodes.keys()].filter((name) => debug || !isDebugNode(name)).sort();
  const publishers = new Map();
  const subscribers = new Map();
  for (const node of nodes) {
    const {publishing, subscribing} = system.nodes.get(node);
    for (const [names, map] of [[publishing, publishers], [subscribing, subscribers]]) {
      for (const name of names) {
        if (!debug && isDebugTopic(name)) continue;
        if (!map.has(name)) map.set(name, []);
        map.get(name).push(node);
      }
    }
  }
  const all = [...new Set([...publishers.keys(), ...subscribers.keys()])].sort().filter((name) => (
    loose || (publishers.has(name) && subscribers.has(name))));
  const edges = [];
  if (topics) {
    for (const name of all) {
      for (const node of publishers.get(name) || []) edges.push([`n:${node}`, `t:${name}`, '']);
      for (const node of subscribers.get(name) || []) edges.push([`t:${name}`, `n:${node}`, '']);
    }
  } else {
    const labels = new Map();
    for (const name of all) {
      for (const from of publishers.get(name) || []) {
        for (const to of subscribers.get(name) || []) {
          const key = JSON.stringify([from, to]);
          if (!labels.has(key)) labels.set(key, []);
          labels.get(key).push(name);
        }
      }
    }
    for (const [key, names] of labels) {
      const [from, to] = JSON.parse(key);
      edges.push([`n:${from}`, `n:${to}`, names.length > 2 ? `${names[0]} and ${names.length - 1} more` : names.join(', ')]);
    }
  }
  const graph = {nodes, topics: topics ? all : [], edges};
  return filter ? near(graph, filter.toLowerCase()) : graph;
}

// Return the nodes and topics whose names contain a text, with their neighbours; of a node also those behind its topics.
function near(graph, filter) {
  const kept = new Set([...graph.nodes.map((name) => `n:${name}`), ...graph.topics.map((name) => `t:${name}`)]
    .filter((key) => key.slice(2).toLowerCase().includes(filter)));
  for (let i = 0; i < 2; i += 1) {
    const found = [...kept];
    for (const [from, to] of graph.edges) {
      if (found.includes(from)) kept.add(to);
      if (found.includes(to)) kept.add(from);
    }
  }
  return {nodes: graph.nodes.filter((name) => kept.has(`n:${name}`)),
          topics: graph.topics.filter((name) => kept.has(`t:${name}`)),
          edges: graph.edges.filter(([from, to]) => kept.has(from) && kept.has(to))};
}
