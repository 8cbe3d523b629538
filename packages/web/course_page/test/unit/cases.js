// What test_browser_panels.py does with modules of the page: browser.call(CASES, 'cases.NAME', ...).

const STILL = {translation: {x: 0, y: 0, z: 0}, rotation: {x: 0, y: 0, z: 0, w: 1}};

async function until(condition) {
  const start = performance.now();
  while (!condition() && performance.now() < start + 20000) await new Promise((done) => setTimeout(done, 20));
  return performance.now() - start;
}

// A WebSocket that is open and sends nothing.
class Socket {
  static OPEN = 1;

  constructor() {
    Socket.last = this;
    this.readyState = Socket.OPEN;
    setTimeout(() => this.onopen());
  }

  send() {}
}

window.cases = {
  // The rows of the panel Frames after messages [time, fixed, [[parent, child], ...]].
  async frameTree(messages, now) {
    const {FrameTree} = await import('/panels/frames.js');
    const tree = new FrameTree();
    for (const [time, fixed, pairs] of messages) {
      tree.add({transforms: pairs.map(([parent, child]) => (
        {header: {frame_id: parent}, child_frame_id: child, transform: STILL}))}, fixed, time);
    }
    const {rows, trees} = tree.rows(now);
    return {trees, rows: rows.map(({name, depth, faults}) => [name, depth, faults.join()])};
  },

  // Poses of frames in others, after transforms [parent, child, x, y, yaw].
  async poses(transforms, pairs) {
    const {Transforms} = await import('/app/frames.js');
    const takers = [];
    const frames = new Transforms({subscribe: (topic, type, take) => takers.push(take)});
    for (const [parent, child, x, y, yaw] of transforms) {
      takers[0]({transforms: [{header: {frame_id: parent}, child_frame_id: child, transform: {
        translation: {x, y}, rotation: {x: 0, y: 0, z: Math.sin(yaw / 2), w: Math.cos(yaw / 2)}}}]});
    }
    return pairs.map(([frame, parent]) => frames.pose(frame, parent));
  },

  // Whether a link counts as stalled before the server is silent, and when something comes again; and after what time [ms].
  async silence() {
    const before = [window.WebSocket, window.fetch];
    let silent = false;
    window.WebSocket = Socket;
    window.fetch = () => (silent ? new Promise(() => {}) : Promise.resolve(
      {ok: true, json: async () => ({master: true, ready: true, uri: '', name: '/browser'})}));
    const {Ros} = await import('/app/ros.js');
    const ros = new Ros('ws://nowhere');
    await until(() => ros.node === '/browser' && ros.state.link === 'open');
    const calm = ros.state.stalled;
    silent = true;
    const time = await until(() => ros.state.stalled);
    Socket.last.onmessage({data: JSON.stringify({op: 'publish', topic: '/a', msg: {}})});
    const after = ros.state.stalled;
    [window.WebSocket, window.fetch] = before;
    return [calm, time, after];
  },

  // How far [px] a message reaches below the bar.
  async toast() {
    const {toast} = await import('/app/shell.js');
    toast('Step 5 of the course is done.');
    const {bottom} = document.querySelector('.toast').getBoundingClientRect();
    return bottom - document.querySelector('.bar').clientHeight;
  },

  // A list of rows by namespaces: its order, and which are open after one was closed, again, and in a search.
  async namespaces() {
    const {NamespaceList} = await import('/panels/lib/rows.js');
    const row = (name) => ({name, element: document.createElement('li')});
    const open = (list) => [...list.element.children].map((element) => element.open);
    const list = new NamespaceList('x');
    const rows = ['/b/y', '/b/x', '/a', '/c/z'].map(row);
    rows[3].element.hidden = true;
    list.arrange(rows);
    const order = rows.slice(0, 2).map(({element}) => [...element.parentNode.children].indexOf(element));
    list.element.querySelectorAll('summary')[1].click(); // closes /b
    list.arrange(rows.slice(0, 3));
    const other = new NamespaceList('x');
    other.arrange(rows.slice(0, 3));
    const again = open(other);
    other.arrange(rows.slice(0, 3), true);
    const titles = [...other.element.querySelectorAll('summary')].map((element) => element.textContent);
    return [order, open(list), again, open(other), titles];
  },

  // The boxes of a graph of so many nodes in a circle.
  async graph(count) {
    const {layOut} = await import('/panels/graph.js');
    const nodes = Array.from({length: count}, (_, i) => `/node${i}`);
    const edges = nodes.flatMap((name, i) => [[`n:${name}`, `t:${name}/topic`, ''],
                                              [`t:${name}/topic`, `n:/node${(i + 1) % count}`, '']]);
    return layOut({nodes, topics: nodes.map((name) => `${name}/topic`), edges}, (text) => 7 * text.length).nodes;
  },
};
