// The panels, in the order of the menu. A panel's module is loaded when it is shown for the first time.
// icon: the path of a drawing of 24 x 24, with lines of width 2.
export const PANELS = [
  {id: 'turtle', title: 'Turtle', group: 'Simulators', icon: 'M12 5c4 0 7 3 7 6.5S16 18 12 18s-7-3-7-6.5S8 5 12 5zM12 5V3M6 7 4 5M18 7l2-2M6.5 16.5 5 19M17.5 16.5 19 19M9 10l3-2 3 2v3l-3 2-3-2z',
    load: () => import('../panels/turtle.js')},
  {id: 'robot', title: 'Robotont', group: 'Simulators', icon: 'M12 3a9 9 0 1 0 0 18 9 9 0 0 0 0-18zM12 7l4 7H8z',
    load: () => import('../panels/robot.js')},
];
