// What a user does in a window of cv2.imshow: keys for waitKey, the mouse, trackbars. rospy_support's cv2_windows.py
// publishes the window as an image topic, and listens to the topics below that.
import {el, fill} from '../../app/dom.js';
import {clean} from './values.js';

const TOPIC = /^\/cv_window\/\w+$/;
const KEY = /^(.|Enter|Escape|Backspace|Delete|Home|End|Page(Up|Down)|Arrow(Left|Right|Up|Down))$/u;
const EVENTS = {pointermove: 0, pointerdown: [1, 3, 2], pointerup: [4, 6, 5]}; // of cv2, by button
const MOVE_PERIOD = 50; // ms between two positions of the mouse

export function isCvWindow(topic) {
  return TOPIC.test(topic);
}

// Return the controls of a window below its picture, until `scope` ends. `place(event)` gives the pixel of an event.
export function cvWindowControls({topic, scope, picture, place, keys}) {
  const {ros} = scope;
  const sliders = el('div', {class: 'toolbar'});
  if (keys) scope.listen(document, 'keydown', (event) => press(event, topic, ros));
  let last = 0;
  for (const [name, number] of Object.entries(EVENTS)) {
    scope.listen(picture, name, (event) => {
      const pixel = place(event);
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
  const said = keys ? 'A window of cv2: the keys that you type and the mouse go to the program.'
    : 'A window of cv2: the mouse goes to the program; the keys go to the other panel.';
  return el('div', {}, sliders, el('p', {class: 'muted small'}, said));
}

function press(event, topic, ros) {
  const busy = event.target.closest?.('input, select, textarea, button, summary, a, [contenteditable]');
  if (busy || event.ctrlKey || event.altKey || event.metaKey || !KEY.test(event.key)) return;
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
