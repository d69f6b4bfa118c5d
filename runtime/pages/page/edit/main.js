// The page of `cdb view --serve`: the editor of a scenario.
import { Editor } from './editor.js';

new Editor(JSON.parse(document.getElementById('data').textContent), document.getElementById('page'));
