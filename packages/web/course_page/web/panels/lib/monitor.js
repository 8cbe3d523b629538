// The last message, rate and bandwidth of a topic while a panel shows it.
import {sizeOf} from './values.js';

const WINDOW = 3; // s
const LIGHT = 20000; // bytes: larger messages are not all fetched
const SAMPLE_RATE = 2; // Hz, for topics with large messages

// Counts messages and bytes; times are in seconds.
export class Meter {
  constructor() {
    this._marks = []; // [time, messages, bytes]
  }

  add(time, bytes, messages = 1) {
    this._marks.push([time, messages, bytes * messages]);
    while (this._marks.length > 2 && this._marks[1][0] < time - WINDOW) this._marks.shift();
  }

  // Return {rate, bandwidth} at a time; null for each while there are too few messages.
  read(now) {
    const marks = this._marks;
    if (marks.length < 2) return null;
    const first = marks[0];
    const last = marks[marks.length - 1];
    const span = Math.max(last[0] - first[0], 1e-3);
    const between = span / (marks.length - 1);
    if (now - last[0] > Math.max(WINDOW, 3 * between)) return {rate: 0, bandwidth: 0};
    let messages = 0;
    let bytes = 0;
    for (let i = 1; i < marks.length; i += 1) {
      messages += marks[i][1];
      bytes += marks[i][2];
    }
    return {rate: messages / span, bandwidth: bytes / span};
  }
}

// Subscribes to a topic until `end()`. Of large messages only some are fetched; the sequence numbers in their headers
// then tell how many there were.
export class Monitor {
  constructor(ros, topic, type, types) {
    this.message = undefined;
    this.count = 0;
    this.size = 0; // bytes of the last message
    this.partial = false; // whether the rate may be higher than shown
    this._ros = ros;
    this._topic = topic;
    this._type = type;
    this._types = types;
    this._meter = new Meter();
    this._sequence = null;
    this._light = false;
    this._end = this._subscribe(SAMPLE_RATE);
  }

  read() {
    return this._meter.read(performance.now() / 1000);
  }

  end() {
    this._end();
  }

  _subscribe(rate) {
    return this._ros.subscribe(this._topic, this._type, (message) => this._received(message), {rate});
  }

  _received(message) {
    this.message = message;
    this.count += 1;
    this.size = sizeOf(message, this._types.root, null, this._types);
    if (!this._light && this.size <= LIGHT) {
      this._light = true;
      const end = this._end;
      this._end = this._subscribe(0);
      end();
      return;
    }
    this._meter.add(performance.now() / 1000, this.size, this._light ? 1 : this._skipped(message));
  }

  // Return how many messages have been published since the last received one.
  _skipped(message) {
    const sequence = message.header ? message.header.seq : undefined;
    const before = this._sequence;
    this._sequence = sequence;
    this.partial = !(sequence > before);
    return before !== null && sequence > before && sequence - before < 10000 ? sequence - before : 1;
  }
}
