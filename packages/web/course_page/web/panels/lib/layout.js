// The layout of nodes and topics.
import dagre from '../../vendor/dagre/dagre.esm.js';
import {shortName} from './names.js';

const HEIGHT = 34; // px of a node
const PADDING = 26; // px beside its name
const MAX_PARTS = 400; // nodes and edges that are laid out, which takes up to about a second

// Return {width, height, nodes: [{key, name, x, y, width, height}], edges: [{from, to, label, points, x, y}]}, or null if
// the graph is too large. `widthOf(text)` is that of a text [px]; `down`: from top to bottom instead of left to right.
export function layOut({nodes, topics, edges}, widthOf, down = false) {
  if (nodes.length + topics.length + edges.length > MAX_PARTS) return null;
  const graph = new dagre.graphlib.Graph({multigraph: true});
  graph.setGraph({rankdir: down ? 'TB' : 'LR', nodesep: 18, ranksep: 46, edgesep: 10, marginx: 12, marginy: 12});
  graph.setDefaultEdgeLabel(() => ({}));
  const all = [...nodes.map((name) => [`n:${name}`, name]), ...topics.map((name) => [`t:${name}`, name])];
  for (const [key, name] of all) {
    graph.setNode(key, {name, width: widthOf(shortName(name)) + PADDING, height: HEIGHT});
  }
  for (const [from, to, label] of edges) {
    graph.setEdge(from, to, label ? {label, width: widthOf(shortName(label)), height: 14, labelpos: 'c'} : {}, label || undefined);
  }
  dagre.layout(graph);
  const {width, height} = graph.graph();
  return {
    width: Number.isFinite(width) ? width : 0, height: Number.isFinite(height) ? height : 0,
    nodes: graph.nodes().map((key) => {
      const {name, x, y, width: w, height: h} = graph.node(key);
      return {key, name, x, y, width: w, height: h};
    }),
    edges: graph.edges().map((edge) => {
      const {label = '', points, x, y} = graph.edge(edge);
      return {from: edge.v, to: edge.w, label, points, x, y};
    }),
  };
}

// Return the drawing that appears largest in a frame; null if there is none.
export function largest(drawings, width, height) {
  const scale = (drawing) => Math.min((width || 1) / drawing.width, (height || 1) / drawing.height);
  return drawings.filter(Boolean).reduce((best, one) => (best && scale(best) >= scale(one) ? best : one), null);
}
