// The panels, in the order of the menu. The shell loads panels/ID.js when the panel is shown for the first time.
// icon: the path of a drawing of 24 x 24, with lines of width 2.
export const PANELS = [
  {id: 'turtle', title: 'Turtle', group: 'Simulators', icon: 'M12 5c4 0 7 3 7 6.5S16 18 12 18s-7-3-7-6.5S8 5 12 5zM12 5V3M6 7 4 5M18 7l2-2M6.5 16.5 5 19M17.5 16.5 19 19M9 10l3-2 3 2v3l-3 2-3-2z'},
  {id: 'robot', title: 'Robotont', group: 'Simulators', icon: 'M12 3a9 9 0 1 0 0 18 9 9 0 0 0 0-18zM12 7l4 7H8z'},
  {id: 'start', title: 'Start', group: 'Simulators', icon: 'M12 3a9 9 0 1 0 0 18 9 9 0 0 0 0-18zM10 8l6 4-6 4z'},
  {id: 'map', title: 'Map', group: 'Simulators', icon: 'M4 6l5-2 6 2 5-2v14l-5 2-6-2-5 2zM9 4v14M15 6v14'},
  {id: 'plot', title: 'Plot', group: 'Look', icon: 'M4 4v16h16M7 15l4-5 3 3 5-7'},
  {id: 'image', title: 'Image', group: 'Look', icon: 'M4 5h16v14H4zM4 16l5-5 4 4 3-3 4 4M15.5 9.500v.01'},
  {id: 'markers', title: 'Markers', group: 'Look', icon: 'M4 8V4h4M16 4h4v4M20 16v4h-4M8 20H4v-4M10 10a2 2 0 1 1 2.5 2c-.5.2-.5.6-.5 1.2M12 16v.01'},
  {id: 'console', title: 'Console', group: 'Look', icon: 'M4 5h16v14H4zM7 9l3 3-3 3M12 15h5'},
  {id: 'graph', title: 'Graph', group: 'ROS', icon: 'M6 8.5a2.5 2.5 0 1 1 0-5 2.5 2.5 0 0 1 0 5zM18 14.5a2.5 2.5 0 1 1 0-5 2.5 2.5 0 0 1 0 5zM6 20.5a2.5 2.5 0 1 1 0-5 2.5 2.5 0 0 1 0 5zM8.3 7l7.4 4M8.3 17l7.4-4'},
  {id: 'topics', title: 'Topics', group: 'ROS', icon: 'M5 7h14M5 12h9M5 17h12'},
  {id: 'nodes', title: 'Nodes', group: 'ROS', icon: 'M5 4h5v5H5zM14 4h5v5h-5zM5 14h5v5H5zM14 14h5v5h-5z'},
  {id: 'frames', title: 'Frames', group: 'ROS', icon: 'M12 3v12M12 15l8 5M12 15l-8 5M12 3l-2 3M12 3l2 3'},
  {id: 'services', title: 'Services', group: 'ROS', icon: 'M4 9h14l-4-4M20 15H6l4 4'},
  {id: 'parameters', title: 'Parameters', group: 'ROS', icon: 'M4 7h9M17 7h3M4 17h3M11 17h9M15 5v4M9 15v4'},
  {id: 'reconfigure', title: 'Reconfigure', group: 'ROS', icon: 'M4 6h16M4 12h16M4 18h16M8 4v4M15 10v4M10 16v4'},
  {id: 'course', title: 'Course', group: 'Learn', icon: 'M4 5c3-1 6-1 8 1v13c-2-2-5-2-8-1zM20 5c-3-1-6-1-8 1v13c2-2 5-2 8-1z'},
  {id: 'grade', title: 'Grade', group: 'Learn', icon: 'M5 4h14v16H5zM8 12l3 3 5-6'},
];
