// What tests read from a page, and do there, that WebDriver has no command for: browser.call(LOOKS, 'looks.NAME', ...).

const boxOf = (element) => element.getBoundingClientRect();

window.looks = {
  // The pixels of turtlesim's canvas, in base64.
  pixels() {
    const canvas = document.querySelector('canvas.strokes');
    const {data} = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    let text = '';
    for (let at = 0; at < data.length; at += 32768) text += String.fromCharCode(...data.subarray(at, at + 32768));
    return btoa(text);
  },

  setRate(rate) {
    const label = [...document.querySelectorAll('label')].find((element) => element.textContent === 'Rate');
    const input = label.querySelector('input');
    input.value = rate;
    input.dispatchEvent(new Event('change'));
  },

  // The middle of an element, which is scrolled into the window.
  middle(selector) {
    const element = document.querySelector(selector);
    element.scrollIntoView({block: 'center'});
    const box = boxOf(element);
    return [box.x + box.width / 2, box.y + box.height / 2];
  },

  // Keep the map of the Robotont's world, which it tells with its next picture.
  async catchMap() {
    const {WorldMap} = await import('/app/map.js');
    const draw = WorldMap.prototype._draw;
    WorldMap.prototype._draw = function () {
      window.shownMap = this;
      draw.call(this);
    };
  },

  // Where a marker is in the window: x, y [px], and the scale [px/m]; null until the map has markers.
  marker(name) {
    const panel = window.shownMap?.world?.panels.find((one) => one.name === name);
    if (!panel) return null;
    const {x, y, scale} = shownMap._extent();
    const box = boxOf(shownMap.element);
    return [box.x + box.width / 2 + (panel.x - x) * scale, box.y + box.height / 2 - (panel.y - y) * scale, scale];
  },

  // Those of the elements that are not whole in the window, are too small, or have something over their middle.
  hidden(selectors) {
    return selectors.filter((selector) => {
      const element = document.querySelector(selector);
      const box = boxOf(element);
      const top = document.elementFromPoint(box.x + box.width / 2, box.y + box.height / 2);
      return Math.min(box.width, box.height) < 40 || box.x < 0 || box.y < 0 || box.right > innerWidth
        || box.bottom > innerHeight || !element.contains(top);
    });
  },

  // What axe-core, which is loaded, finds.
  async violations() {
    const {violations} = await axe.run(document, {
      runOnly: {type: 'tag', values: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa', 'best-practice']},
      rules: {'label-content-name-mismatch': {enabled: true}}});
    return violations.map(({id, nodes}) => [id, nodes.map(({html}) => html.slice(0, 200))]);
  },

  // The element with the focus, whether it has a ring, and how many elements move.
  focused() {
    const {outlineStyle, outlineWidth} = getComputedStyle(document.activeElement);
    const moving = [...document.querySelectorAll('*')].filter((element) => {
      const {transitionDuration, animationName} = getComputedStyle(element);
      return animationName !== 'none' || transitionDuration.split(', ').some((time) => time !== '0s');
    });
    return [document.activeElement.outerHTML.slice(0, 200), outlineStyle !== 'none' && parseFloat(outlineWidth) >= 2,
            moving.length];
  },

  // The nodes and topics of the graph that are not in its frame.
  outsideOfGraph() {
    const frame = boxOf(document.querySelector('svg.graph'));
    return [...document.querySelectorAll('.graph .node, .graph .topic')].filter((element) => {
      const {left, right, top, bottom} = boxOf(element);
      return left < frame.left || right > frame.right || top < frame.top || bottom > frame.bottom;
    }).map((element) => element.textContent);
  },

  chooseInGraph(name) {
    [...document.querySelectorAll('.graph .node')].find((element) => element.textContent.includes(name))
      .dispatchEvent(new Event('click'));
  },

  // Show or hide the page, as when another tab is chosen.
  hide(hidden) {
    Object.defineProperty(document, 'hidden', {get: () => hidden, configurable: true});
    document.dispatchEvent(new Event('visibilitychange'));
  },

  // Draw an arrow of 80 px upwards from the middle of the map.
  arrowOnMap() {
    const map = document.querySelector('.map');
    const box = boxOf(map);
    map.setPointerCapture = () => {};
    for (const [type, up] of [['pointerdown', 0], ['pointermove', 80], ['pointerup', 80]]) {
      map.dispatchEvent(new PointerEvent(type, {bubbles: true, pointerId: 1, clientX: box.left + box.width / 2,
                                                clientY: box.top + box.height / 2 - up}));
    }
  },
};
