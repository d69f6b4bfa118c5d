// The page of `cdb view`: a scene, or, with `cdb view --serve`, the editor of a scenario.
import { App } from './app.js';
import { Editor } from './editor.js';

const data = JSON.parse(document.getElementById('data').textContent);
const page = document.getElementById('page');
if (data.editor) {
  new Editor(data, page);
} else {
  page.className = 'app';
  new App(data, page);
}
