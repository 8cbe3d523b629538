// Images of cameras and trackers.
import {el, emptyState, fill} from '../app/dom.js';
import {Video} from '../app/video.js';
import {button, choice, Notice, Panel, save, Scope, setText} from './lib/parts.js';
import {clean} from './lib/values.js';

const RAW = 'sensor_msgs/Image';
const COMPRESSED = 'sensor_msgs/CompressedImage';
const LIST = 2; // s between two polls for topics
const POLL_INTERVAL = 1; // s between two checks of the picture
const STILL = 5; // s without a change, after which the panel says so
const RATE = 15; // compressed images a second
const FORMATS = {jpeg: 'image/jpeg', jpg: 'image/jpeg', png: 'image/png'};
const CV_WINDOW = /^\/cv_window\/\w+$/;
const CV_KEY = /^(.|Enter|Escape|Backspace|Delete|Home|End|Page(Up|Down)|Arrow(Left|Right|Up|Down))$/u;
const CV_EVENTS = {pointermove: 0, pointerdown: [1, 3, 2], pointerup: [4, 6, 5]}; // of cv2, by button
const MOVE_PERIOD = 50; // ms between two positions of the mouse

export const help = [
  'The pictures of cameras and trackers, always the newest one. Press on it to read the colour of a pixel.',
  'In a terminal: rosrun web_video_server web_video_server.'];

export default class ImagePanel extends Panel {
  constructor(element, context) {
    super(context);
    this._topic = context.parameters.topic || '';
    this._types = new Map();
    this._known = '';
    this._running = null; // the type of the topic that is shown
    this._end = () => {};
    this._select = choice('Topic', [], () => this._choose(this._select.input.value));
    this._quality = choice('Quality', [['50', 'small'], ['80', 'good'], ['png', 'exact']], () => this._start());
    this._quality.input.value = '80';
    this._freeze = button('Pause', () => this._setFrozen(!this._frozen), {'aria-pressed': 'false'});
    this._notice = new Notice();
    this._empty = el('div', {});
    this._picture = el('img', {alt: '', draggable: false, on: {
      error: () => this._failed(), click: (event) => this._read(event)}});
    this._video = new Video(this._picture);
    this._still = el('canvas', {hidden: true, on: {click: (event) => this._read(event)}});
    this._facts = el('p', {class: 'muted small'});
    this._pixel = el('p', {class: 'number small', role: 'status'});
    this._controls = el('div', {});
    this._box = el('div', {class: 'image-box'}, this._picture, this._still);
    this._tools = el('div', {class: 'row'}, this._freeze, button('Save', () => this._save()),
      button('Full screen', () => this._box.requestFullscreen?.()));
    fill(element, el('div', {class: 'toolbar'}, this._select.element, this._quality.element, this._tools), this._notice.element,
         this._empty, this._box, this._controls, this._facts, this._pixel);
    this.scope.every(LIST, () => this._list(), (error) => this._notice.say(error.message, true));
    this.scope.every(POLL_INTERVAL, () => this._poll());
    this.scope.listen(document, 'visibilitychange', () => (document.hidden ? this._stop() : this._start()));
    this.scope.add(() => this._stop());
  }

  async _list() {
    const topics = (await this.context.rosapi.topics()).filter(({type}) => type === RAW || type === COMPRESSED);
    if (this.scope.ended) return;
    const known = JSON.stringify(topics);
    if (known === this._known) return;
    this._known = known;
    this._types = new Map(topics.map(({name, type}) => [name, type]));
    const names = [...this._types.keys()].sort();
    if (this._topic && !this._types.has(this._topic)) names.unshift(this._topic);
    fill(this._select.input, names.map((name) => el('option', {value: name}, clean(name, 100))));
    this._select.element.hidden = !names.length;
    this._choose(this._topic || bestPicture(topics) || names[0] || '', true);
  }

  _choose(name, kept = false) {
    const same = name === this._topic && this._running === this._types.get(name) && kept;
    this._topic = name;
    this._select.input.value = name;
    this.context.setParameters({topic: name});
    if (!same) this._start();
  }

  _start() {
    this._stop();
    this._setFrozen(false);
    this._pixel.textContent = '';
    this._changed = performance.now();
    this._print = '';
    const type = this._running = this._types.get(this._topic);
    const shown = this._box.hidden = this._tools.hidden = this._facts.hidden = !type;
    this._quality.element.hidden = type !== RAW;
    this._notice.say('');
    if (shown) {
      fill(this._empty, this._topic
        ? emptyState('No such picture yet', `No node publishes ${clean(this._topic, 100)}. It appears here as soon as a node does.`)
        : emptyState('No pictures yet', 'No node publishes pictures. These commands start a camera:',
                     'roslaunch turtle_robotont ar_control.launch', 'roslaunch robotont_gazebo world_minimaze_ar.launch'));
      return;
    }
    fill(this._empty);
    this._picture.alt = `Picture of ${clean(this._topic, 100)}`;
    if (document.hidden) return;
    if (type === RAW) {
      const quality = this._quality.input.value;
      const how = quality === 'png' ? {type: 'png'} : {type: 'mjpeg', quality};
      this._video.show({topic: this._topic, ...how});
      const scope = new Scope(this.context.ros);
      if (isCvWindow(this._topic)) this._control(scope);
      this._end = () => {
        scope.end();
        fill(this._controls);
        this._video.stop();
      };
    } else {
      this._end = this.context.ros.subscribe(this._topic, type, (message) => this._showCompressed(message), {rate: RATE});
    }
  }

  _stop() {
    this._end();
    this._end = () => {};
  }

  _control(scope) {
    fill(this._controls, cvWindowControls({
      topic: this._topic, scope, picture: this._picture, keys: this.context.keys,
      pixelOf: (event) => this._pixelOf(event, this._picture)}));
  }

  _showCompressed(message) {
    const format = Object.keys(FORMATS).find((name) => String(message.format).toLowerCase().includes(name));
    if (!format || !/^[A-Za-z0-9+/=]*$/.test(message.data)) {
      this._notice.say(`Pictures of the format "${clean(message.format, 60)}" cannot be shown; JPEG and PNG can.`, true);
      return;
    }
    this._picture.src = `data:${FORMATS[format]};base64,${message.data}`;
  }

  _failed() {
    if (!this._picture.getAttribute('src')) return;
    this._notice.say(this._running === RAW
      ? 'The server shows no video of this topic. Is the page opened from browser.launch?'
      : 'A picture of this topic is damaged.', true);
  }

  // Say how large the picture is, and whether it changes.
  _poll() {
    const {naturalWidth: width, naturalHeight: height} = this._picture;
    if (!this._running || this._frozen) return;
    const seconds = (performance.now() - this._changed) / 1000;
    if (!width) {
      setText(this._facts, seconds < STILL ? 'Waiting for the first picture …' : 'No picture has arrived yet: does a node publish?');
      return;
    }
    const print = this._fingerprint();
    if (print !== this._print) {
      this._print = print;
      this._changed = performance.now();
    }
    const still = seconds > STILL ? ` It has not changed for ${Math.floor(seconds)} s.` : '';
    setText(this._facts, `${width} x ${height} pixels.${still}`);
  }

  // Return a text that changes with the picture.
  _fingerprint() {
    const canvas = this._small ||= el('canvas', {width: 32, height: 24});
    const drawing = canvas.getContext('2d', {willReadFrequently: true});
    drawing.drawImage(this._picture, 0, 0, canvas.width, canvas.height);
    return drawing.getImageData(0, 0, canvas.width, canvas.height).data.join();
  }

  _copy() {
    const canvas = el('canvas', {width: this._picture.naturalWidth, height: this._picture.naturalHeight});
    canvas.getContext('2d').drawImage(this._picture, 0, 0);
    return canvas;
  }

  _setFrozen(frozen) {
    if (frozen && !this._picture.naturalWidth) return;
    this._frozen = frozen;
    if (frozen) {
      const copy = this._copy();
      Object.assign(this._still, {width: copy.width, height: copy.height});
      this._still.getContext('2d').drawImage(copy, 0, 0);
    }
    this._still.hidden = !frozen;
    this._picture.hidden = frozen;
    this._freeze.textContent = frozen ? 'Live' : 'Pause';
    this._freeze.setAttribute('aria-pressed', String(frozen));
  }

  _source() {
    return this._frozen ? this._still : this._picture.naturalWidth ? this._copy() : null;
  }

  // Return the pixel {x, y} below the pointer, or null without a picture.
  _pixelOf(event, shown) {
    const [width, height] = [shown.naturalWidth ?? shown.width, shown.naturalHeight ?? shown.height];
    const box = shown.getBoundingClientRect();
    return width ? {x: Math.min(width - 1, Math.max(0, Math.floor((event.clientX - box.x) / box.width * width))),
                    y: Math.min(height - 1, Math.max(0, Math.floor((event.clientY - box.y) / box.height * height)))} : null;
  }

  _read(event) {
    const source = this._source();
    if (!source) return;
    const {x, y} = this._pixelOf(event, event.currentTarget);
    const [r, g, b] = source.getContext('2d').getImageData(x, y, 1, 1).data;
    setText(this._pixel, `Pixel x ${x}, y ${y}: red ${r}, green ${g}, blue ${b}`);
  }

  _save() {
    const source = this._source();
    if (!source) {
      this._notice.say('There is no picture to save yet.', true);
      return;
    }
    source.toBlob((blob) => save(`${this._topic.replace(/\W+/g, '_').replace(/^_/, '')}.png`, blob), 'image/png');
  }
}

// Return the topic to show at first: of those that need no subscription of the page, a camera's colours before distances.
export function bestPicture(topics) {
  const raw = topics.filter(({type}) => type === RAW).map(({name}) => name).sort();
  return raw.find((name) => /color|rgb|usb_cam/.test(name)) ?? raw.find((name) => !/depth|mask/.test(name)) ?? raw[0];
}

// What a user does in a window of cv2.imshow: keys for waitKey, the mouse, trackbars. rospy_support's cv2_windows.py
// publishes the window as an image topic, and listens to the topics below that.
function isCvWindow(topic) {
  return CV_WINDOW.test(topic);
}

// Return the controls of a window below its picture, until `scope` ends. `pixelOf(event)` gives the pixel of an event.
function cvWindowControls({topic, scope, picture, pixelOf, keys}) {
  const {ros} = scope;
  const sliders = el('div', {class: 'toolbar'});
  if (keys) scope.listen(document, 'keydown', (event) => press(event, topic, ros));
  let last = 0;
  for (const [name, number] of Object.entries(CV_EVENTS)) {
    scope.listen(picture, name, (event) => {
      const pixel = pixelOf(event);
      const moved = name === 'pointermove';
      if (!pixel || (moved && performance.now() - last < MOVE_PERIOD)) return;
      last = performance.now();
      ros.publish(`${topic}/mouse`, 'geometry_msgs/Point', {...pixel, z: moved ? number : number[event.button] ?? 0});
    });
  }
  let shown = '';
  scope.add(ros.subscribe(`${topic}/trackbars`, 'std_msgs/String', ({data}) => {
    const trackbars = parsed(data);
    const same = JSON.stringify(trackbars.map(({name, least, most}) => [name, least, most]));
    if (same !== shown) {
      shown = same;
      fill(sliders, trackbars.map((trackbar) => slider(topic, trackbar, ros)));
    }
    trackbars.forEach(({value}, index) => set(sliders.children[index], value));
  }));
  const text = keys ? 'A window of cv2: the keys that you type and the mouse go to the program.'
    : 'A window of cv2: the mouse goes to the program; the keys go to the other panel.';
  return el('div', {}, sliders, el('p', {class: 'muted small'}, text));
}

function press(event, topic, ros) {
  const busy = event.target.closest?.('input, select, textarea, button, summary, a, [contenteditable]');
  if (busy || event.ctrlKey || event.altKey || event.metaKey || !CV_KEY.test(event.key)) return;
  event.preventDefault();
  ros.publish(`${topic}/key`, 'std_msgs/String', {data: event.key});
}

// Return the trackbars in a message; none for a text of another kind, which anybody may publish.
function parsed(text) {
  try {
    return JSON.parse(text).map(({name, value, least, most}) => (
      {name: String(name), value: Number(value), least: Number(least), most: Number(most)}));
  } catch {
    return [];
  }
}

function slider(topic, {name, least, most}, ros) {
  const value = el('output', {class: 'number'});
  const input = el('input', {type: 'range', min: least, max: most, step: 1, on: {input: () => {
    value.textContent = input.value;
    ros.publish(`${topic}/trackbar/${name.replace(/\W/g, '_')}`, 'std_msgs/Int32', {data: Number(input.value)});
  }}});
  return el('label', {class: 'field'}, clean(name, 60), input, value);
}

function set(label, number) {
  const [input, value] = label.querySelectorAll('input, output');
  if (input !== document.activeElement || !input.matches(':active')) input.value = number;
  value.textContent = number;
}
