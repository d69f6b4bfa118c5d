// The page of `cdb report`: figures of results.
const data = JSON.parse(document.getElementById('data').textContent);
const heading = document.createElement('h1');
heading.textContent = data.title;
document.getElementById('page').append(heading);
