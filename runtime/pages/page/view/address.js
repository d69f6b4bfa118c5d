// The state of the page in its address, so that a view can be linked.

export function readAddress() {
  const words = new URLSearchParams(location.hash.slice(1));
  const state = {};
  const numberOf = (name) => (words.has(name) && Number.isFinite(Number(words.get(name))) ? Number(words.get(name)) : undefined);
  for (const name of ['time', 'speed', 'magnify']) state[name] = numberOf(name);
  for (const name of ['colour', 'series']) state[name] = words.get(name) ?? undefined;
  if (words.has('show')) state.show = words.get('show').split(' ');
  const camera = words.get('camera')?.split(' ').map(Number);
  if (camera?.length === 6 && camera.every(Number.isFinite)) state.camera = camera;
  const body = words.get('body')?.match(/^([AB])(\d+)$/);
  if (body) state.picked = { run: 'AB'.indexOf(body[1]), body: Number(body[2]) };
  return state;
}

const short = (value) => String(Number(value.toPrecision(6)));

export function writeAddress({ time, speed, magnify, colour, series, show, camera, picked }) {
  const words = new URLSearchParams({
    time: short(time), speed: short(speed), magnify: short(magnify), colour, show: show.join(' '),
    camera: camera.map(short).join(' ') });
  if (series) words.set('series', series);
  if (picked) words.set('body', 'AB'[picked.run] + picked.body);
  history.replaceState(null, '', `#${words}`);
}
