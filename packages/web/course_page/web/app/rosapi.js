// Thin wrappers around the services of rosapi, which the page's server answers.

export class Rosapi {
  constructor(ros) {
    this._ros = ros;
  }

  _call(name, args) {
    return this._ros.call(`/rosapi/${name}`, args);
  }

  // Return [{name, type}] of all topics.
  async topics() {
    const {topics, types} = await this._call('topics');
    return topics.map((name, index) => ({name, type: types[index]}));
  }

  // Return the names of the topics of a type.
  async topicsOfType(type) {
    return (await this._call('topics_for_type', {type})).topics;
  }

  // Return the names of the nodes that publish a topic.
  async publishers(topic) {
    return (await this._call('publishers', {topic})).publishers;
  }

  // Return the names of the nodes that subscribe to a topic.
  async subscribers(topic) {
    return (await this._call('subscribers', {topic})).subscribers;
  }

  async nodes() {
    return (await this._call('nodes')).nodes;
  }

  // Return {publishing, subscribing, services}, each a list of names.
  nodeDetails(node) {
    return this._call('node_details', {node});
  }

  async services() {
    return (await this._call('services')).services;
  }

  // Return a parameter's value, or `otherwise` if it is not set.
  async parameter(name, otherwise = null) {
    return JSON.parse((await this._call('get_param', {name, default: JSON.stringify(otherwise)})).value);
  }

  setParameter(name, value) {
    return this._call('set_param', {name, value: JSON.stringify(value)});
  }

  deleteParameter(name) {
    return this._call('delete_param', {name});
  }
}
