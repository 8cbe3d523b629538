import {Ros} from './ros.js';
import {startShell} from './shell.js';

startShell(new Ros());
