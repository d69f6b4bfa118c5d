// The page of `cdb view`: a scene.
import { App } from './app.js';

const page = document.getElementById('page');
page.className = 'app';
new App(JSON.parse(document.getElementById('data').textContent), page);
