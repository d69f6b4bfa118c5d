// The page of `cdb view`: bodies in 3-D.
const data = JSON.parse(document.getElementById('data').textContent);
const heading = document.createElement('h1');
heading.textContent = data.title;
document.getElementById('page').append(heading);
