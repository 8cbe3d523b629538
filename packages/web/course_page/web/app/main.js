import {withoutToken} from './address.js';
import {Ros} from './ros.js';
import {startShell} from './shell.js';

history.replaceState(null, '', withoutToken(location.href));
startShell(new Ros());
