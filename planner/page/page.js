// Draws what page.cc wrote into #data. Lengths in m, times in s, z up. Everything of one kind is one buffer geometry, so
// that a page of a hundred thousand edges takes a handful of draw calls. A frame is drawn when something has changed.
'use strict';

const root = document.documentElement;
const element = (id) => document.getElementById(id);

// The first error stays in sight, and in data-error for who drives the page.
window.onerror = (message) => {
  if (root.dataset.error) return;
  root.dataset.error = message;
  element('error').textContent = 'This page cannot be drawn: ' + message;
  element('error').hidden = false;
};

const data = JSON.parse(element('data').textContent);
const vector = (numbers, i) => new THREE.Vector3(numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]);
const box = (numbers, i = 0) => new THREE.Box3(vector(numbers, 2 * i), vector(numbers, 2 * i + 1));
const bounds = box(data.world.bounds);
const size = bounds.getSize(new THREE.Vector3());
const center = bounds.getCenter(new THREE.Vector3());
const length = Math.max(size.x, size.y, size.z);  // scale of lines and labels
const plane = data.world.dimension === 2;
const INK = '#24292f', START = '#1a7f37', GOAL = '#c2540a', PATH = '#e0115f', UNREACHABLE = '#8c959f';
const FIELD_OF_VIEW = 32 * Math.PI / 180;  // from top to bottom; three.js sizes points as if it were 90 degrees

// --- geometry ---------------------------------------------------------------------------------------------------------

function geometry(attributes, index) {
  const made = new THREE.BufferGeometry();
  for (const [name, { numbers, items }] of Object.entries(attributes)) {
    made.setAttribute(name, new THREE.Float32BufferAttribute(numbers, items));
  }
  if (index) made.setIndex(index);
  return made;
}

// Copies of one template, each where its matrix puts it (scales only, normals need no more here).
function copies(template, matrices) {
  const position = [], normal = [], index = [];
  const p = new THREE.Vector3();
  for (const matrix of matrices) {
    const first = position.length / 3;
    for (let i = 0; i < template.attributes.position.count; ++i) {
      position.push(...p.fromBufferAttribute(template.attributes.position, i).applyMatrix4(matrix).toArray());
      if (template.attributes.normal) normal.push(...p.fromBufferAttribute(template.attributes.normal, i).toArray());
    }
    if (template.index) for (const i of template.index.array) index.push(first + i);
  }
  const attributes = { position: { numbers: position, items: 3 } };
  if (normal.length) attributes.normal = { numbers: normal, items: 3 };
  return geometry(attributes, template.index ? index : null);
}

function boxMatrix(b) {
  const s = b.getSize(new THREE.Vector3()), c = b.getCenter(new THREE.Vector3());
  return new THREE.Matrix4().makeScale(s.x, s.y, s.z).setPosition(c);
}

function cylinderMatrix(numbers, i) {
  const [x, y, z, radius, height] = numbers.slice(5 * i, 5 * i + 5);
  return new THREE.Matrix4().makeScale(radius, radius, height).setPosition(x, y, z + 0.5 * height);
}

function indices(count, per) { return Array.from({ length: count / per }, (_, i) => i); }

const unitBox = new THREE.BoxBufferGeometry(1, 1, 1);
const unitCylinder = new THREE.CylinderBufferGeometry(1, 1, 1, 32).rotateX(0.5 * Math.PI);

// Tubes along polylines; attribute `time` is the time [s] at which the trajectory comes by, so that a shader can cut it.
class Tubes {
  constructor(radius, sides) {
    Object.assign(this, { radius, sides, position: [], normal: [], time: [], index: [] });
  }

  add(points, step) {
    const first = this.position.length / 3;
    let across = null;
    for (let i = 0; i < points.length; ++i) {
      const along = points[Math.min(i + 1, points.length - 1)].clone().sub(points[Math.max(i - 1, 0)]);
      if (along.lengthSq() < 1e-12) along.set(1, 0, 0);
      across = this.turn(across, along.normalize());
      this.ring(points[i], across, along.clone().cross(across), i * step);
      if (i > 0) this.join(first + (i - 1) * this.sides, first + i * this.sides);
    }
  }

  // A direction across the tube, turned as little as possible from ring to ring.
  turn(across, along) {
    const next = across || (Math.abs(along.z) < 0.9 ? new THREE.Vector3(0, 0, 1) : new THREE.Vector3(1, 0, 0));
    const flat = next.clone().addScaledVector(along, -next.dot(along));
    if (flat.lengthSq() < 1e-9) return this.turn(null, along);
    return flat.normalize();
  }

  ring(p, u, v, time) {
    for (let k = 0; k < this.sides; ++k) {
      const angle = 2 * Math.PI * k / this.sides;
      const n = u.clone().multiplyScalar(Math.cos(angle)).addScaledVector(v, Math.sin(angle));
      this.normal.push(n.x, n.y, n.z);
      this.position.push(p.x + this.radius * n.x, p.y + this.radius * n.y, p.z + this.radius * n.z);
      this.time.push(time);
    }
  }

  join(a, b) {
    for (let k = 0; k < this.sides; ++k) {
      const next = (k + 1) % this.sides;
      this.index.push(a + k, b + next, b + k, a + k, a + next, b + next);
    }
  }

  geometry() {
    const three = (numbers) => ({ numbers, items: 3 });
    const attributes = { position: three(this.position), normal: three(this.normal), time: { numbers: this.time, items: 1 } };
    return geometry(attributes, this.index);
  }
}

// --- the layers -------------------------------------------------------------------------------------------------------

const scene = new THREE.Scene();
scene.add(new THREE.HemisphereLight(0xffffff, 0xb8c0c8, 0.85));
const sun = new THREE.DirectionalLight(0xffffff, 0.35);
sun.position.set(-0.5, -1, 1.6);
scene.add(sun);

function layer(...objects) {
  const group = new THREE.Group();
  for (const object of objects) if (object) group.add(object);
  scene.add(group);
  return group;
}

function lines(positions, options) {
  const made = geometry({ position: { numbers: positions, items: 3 } });
  return new THREE.LineSegments(made, new THREE.LineBasicMaterial({ transparent: true, ...options }));
}

// A text that always faces the camera; `height` of its line in m.
function label(text, position, color, height, bold) {
  const canvas = document.createElement('canvas'), pixels = bold ? 64 : 40;
  const font = (bold ? 'bold ' : '') + pixels + 'px Helvetica, Arial, "Liberation Sans", "DejaVu Sans", sans-serif';
  let context = canvas.getContext('2d');
  context.font = font;
  canvas.width = Math.ceil(context.measureText(text).width) + 24;
  canvas.height = 1.4 * pixels;
  context = canvas.getContext('2d');
  Object.assign(context, { font, textBaseline: 'middle', lineJoin: 'round', lineWidth: 12, strokeStyle: '#fff', fillStyle: color });
  context.strokeText(text, 12, 0.5 * canvas.height);
  context.fillText(text, 12, 0.5 * canvas.height);
  const texture = new THREE.CanvasTexture(canvas);
  texture.minFilter = THREE.LinearFilter;
  const sprite = new THREE.Sprite(new THREE.SpriteMaterial({ map: texture, depthTest: !bold, depthWrite: false }));
  sprite.scale.set(1.4 * height * canvas.width / canvas.height, 1.4 * height, 1);
  sprite.position.copy(position);
  sprite.renderOrder = 9;
  return sprite;
}

function edgesOf(boxes, options) {
  return new THREE.LineSegments(copies(new THREE.EdgesGeometry(unitBox), boxes.map(boxMatrix)),
    new THREE.LineBasicMaterial({ transparent: true, depthWrite: false, ...options }));
}

function makeWalls() {
  const material = new THREE.MeshLambertMaterial({ color: plane ? '#57606a' : '#6e7f91', transparent: true, side: THREE.DoubleSide });
  const boxes = indices(data.world.boxes.length, 6).map((i) => box(data.world.boxes, i));
  const cylinders = indices(data.world.cylinders.length, 5).map((i) => cylinderMatrix(data.world.cylinders, i));
  const walls = {
    material,
    boxes: new THREE.Mesh(copies(unitBox, boxes.map(boxMatrix)), material),
    cylinders: new THREE.Mesh(copies(unitCylinder, cylinders), material),
    edges: edgesOf(boxes, { color: INK }),
    setOpacity(opacity) {
      Object.assign(material, { opacity, depthWrite: opacity > 0.7 });  // what is solid hides, what is not does not
      walls.edges.material.opacity = Math.min(0.5, 0.03 + 0.6 * opacity);
    },
  };
  walls.group = layer(walls.boxes, walls.cylinders, walls.edges);
  return walls;
}

function makeRegion(name, numbers, color) {
  if (!numbers) return null;
  const b = box(numbers), s = b.getSize(new THREE.Vector3());
  const wide = s.x * s.y * s.z > 0.2 * size.x * size.y * size.z;  // would tint all that is seen through it
  const opacity = wide ? 0.02 : 0.16;
  const material = new THREE.MeshBasicMaterial({ color, transparent: true, opacity, depthWrite: false });
  const above = new THREE.Vector3(0, 0, 0.5 * s.z).add(b.getCenter(new THREE.Vector3()));
  const height = 0.034 * length;
  return layer(new THREE.Mesh(copies(unitBox, [boxMatrix(b)]), material), edgesOf([b], { color, opacity: wide ? 0.5 : 0.9 }),
    label(name, above.setZ(above.z + 0.8 * height), color, height, true));
}

function niceStep(span, count) {
  const raw = span / count, power = Math.pow(10, Math.floor(Math.log10(raw)));
  return [1, 2, 5, 10].find((factor) => raw <= factor * power * (1 + 1e-9)) * power;
}

function ticks(low, high, count) {
  const step = niceStep(high - low, count), made = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) made.push(Number((k * step).toFixed(6)));
  return made;
}

// A grid on the floor, the edges of the bounds and metres along three of them.
function makeFrame() {
  const { min, max } = bounds, gap = 0.035 * length, height = (plane ? 0.024 : 0.03) * length, grid = [], texts = [];
  const z = min.z - 0.002 * length;
  const text = (words, x, y, h) => texts.push(label(words, new THREE.Vector3(x, y, h), '#57606a', height, false));
  for (const x of ticks(min.x, max.x, 6)) {
    grid.push(x, min.y, z, x, max.y, z);
    text(String(x), x, min.y - gap, z);
  }
  for (const y of ticks(min.y, max.y, 6)) {
    grid.push(min.x, y, z, max.x, y, z);
    text(String(y), min.x - gap, y, z);
  }
  text('x [m]', center.x, min.y - 2.6 * gap, z);
  text('y [m]', min.x - 2.6 * gap, center.y, z);
  if (!plane) {
    for (const h of ticks(min.z, max.z, 5).filter((h) => h > min.z)) text(String(h), min.x - gap, max.y + 0.4 * gap, h);
    text('z [m]', min.x - 2.6 * gap, max.y + gap, center.z);
  }
  return layer(lines(grid, { color: INK, opacity: 0.2 }), edgesOf([bounds], { color: INK, opacity: 0.6 }), ...texts);
}

// Door i's number where it can be closed.
function makeDoors() {
  if (!data.world.doors) return null;
  const at = indices(data.world.doors.length, 3).map((i) => vector(data.world.doors, i));
  return layer(...at.map((p, i) => label(String(i), p, INK, 0.016 * length, false)));
}

function costColor(cost) {
  if (cost === undefined || cost < 0) return new THREE.Color(UNREACHABLE);
  const { colors, maxCost } = data.roadmap;
  const at = Math.min(cost / maxCost, 1) * (colors.length - 1), low = Math.min(Math.floor(at), colors.length - 2);
  return new THREE.Color(colors[low]).lerp(new THREE.Color(colors[low + 1]), at - low);
}

function disc() {
  const canvas = document.createElement('canvas');
  canvas.width = canvas.height = 32;
  const context = canvas.getContext('2d');
  context.fillStyle = '#fff';
  context.arc(16, 16, 15, 0, 2 * Math.PI);
  context.fill();
  return new THREE.CanvasTexture(canvas);
}

function makeRoadmap() {
  if (!data.roadmap) return null;
  const { vertices, edges, costs = [] } = data.roadmap;
  const colors = indices(vertices.length, 3).map((v) => costColor(costs[v]).toArray());
  const numbers = (values) => ({ numbers: values, items: 3 });
  const ends = [], endColors = [];
  for (const v of edges) {
    ends.push(...vertices.slice(3 * v, 3 * v + 3));
    endColors.push(...colors[v]);
  }
  const look = { vertexColors: THREE.VertexColors, transparent: true, depthWrite: false };
  const spacing = Math.pow(size.x * size.y * (plane ? 1 : size.z) / Math.max(1, colors.length), plane ? 1 / 2 : 1 / 3);
  const points = new THREE.Points(geometry({ position: numbers(vertices), color: numbers(colors.flat()) }),
    new THREE.PointsMaterial({ ...look, size: 0.14 * spacing / Math.tan(0.5 * FIELD_OF_VIEW), map: disc(), alphaTest: 0.3 }));
  const segments = new THREE.LineSegments(geometry({ position: numbers(ends), color: numbers(endColors) }),
    new THREE.LineBasicMaterial(look));
  const setOpacity = (opacity) => {
    segments.material.opacity = 0.65 * opacity;
    points.material.opacity = opacity;
  };
  return { points, segments, setOpacity, group: layer(segments, points) };
}

// What moves and where is drawn after the walls: translucent ones do not grey it, solid ones hide it all the same.
const SEEN_THROUGH = { transparent: true, depthWrite: true };

function onTop(object) {
  object.renderOrder = 5;
  return object;
}

function makePath() {
  if (!data.path || !data.path.points.length) return null;
  const tubes = new Tubes(0.0042 * length, 8);
  tubes.add(indices(data.path.points.length, 3).map((i) => vector(data.path.points, i)), 0);
  return layer(onTop(new THREE.Mesh(tubes.geometry(), new THREE.MeshLambertMaterial({ color: PATH, ...SEEN_THROUGH }))));
}

const clock = { now: { value: 0 }, end: 0 };  // `now` is shared by the materials of all trajectories

// A material that shows only what lies before now.
function cutMaterial(color) {
  const material = new THREE.MeshLambertMaterial({ color, ...SEEN_THROUGH });
  material.onBeforeCompile = (shader) => {
    shader.uniforms.now = clock.now;
    shader.vertexShader = shader.vertexShader.replace('void main() {',
      'attribute float time;\nvarying float v_time;\nvoid main() {\nv_time = time;');
    shader.fragmentShader = shader.fragmentShader.replace('void main() {',
      'uniform float now;\nvarying float v_time;\nvoid main() {\nif (v_time > now) discard;');
  };
  return material;
}

function makeOutcome({ name, color, paths }) {
  const ways = paths.map((path) => indices(path.length, 3).map((i) => vector(path, i)));
  const tubes = new Tubes(0.0026 * length, 6);
  for (const way of ways) tubes.add(way, data.step);
  const radius = data.vehicleRadius || 0.008 * length;
  const vehicles = new THREE.InstancedMesh(new THREE.SphereBufferGeometry(radius, 20, 14),
    new THREE.MeshLambertMaterial({ color, ...SEEN_THROUGH, opacity: 0.8 }), ways.length);
  vehicles.frustumCulled = false;  // its bounds would be those of one sphere at the origin
  const mesh = new THREE.Mesh(tubes.geometry(), cutMaterial(color));
  return { name, color, ways, vehicles, mesh, group: layer(onTop(mesh), onTop(vehicles)) };
}

function placeVehicles(outcome) {
  const place = new THREE.Matrix4(), p = new THREE.Vector3(), at = clock.now.value / data.step;
  outcome.ways.forEach((way, i) => {
    const low = Math.min(Math.floor(at), way.length - 1), high = Math.min(low + 1, way.length - 1);
    p.copy(way[low]).lerp(way[high], Math.min(at - low, 1));
    outcome.vehicles.setMatrixAt(i, place.makeTranslation(p.x, p.y, p.z));
  });
  outcome.vehicles.instanceMatrix.needsUpdate = true;
}

// --- controls ---------------------------------------------------------------------------------------------------------

function row(name, color) {
  const label = document.createElement('label'), text = document.createElement('span');
  text.textContent = name;
  if (color) {
    const swatch = document.createElement('span');
    swatch.className = 'swatch';
    swatch.style.background = color;
    label.append(swatch);
  }
  label.append(text);
  element('switches').append(label);
  return label;
}

function addSwitch(name, group, color) {
  const label = row(name, color), input = document.createElement('input');
  Object.assign(input, { type: 'checkbox', checked: true });
  input.onchange = () => {
    group.visible = input.checked;
    requestFrame();
  };
  label.prepend(input);
  return label;
}

function addSlider(label, min, max, value, set) {
  const input = document.createElement('input');
  Object.assign(input, { type: 'range', min, max, step: 'any', value });
  input.oninput = () => {
    set(Number(input.value));
    requestFrame();
  };
  set(value);
  label.append(input);
}

function showScale() {
  const { colors, maxCost } = data.roadmap;
  element('bar').style.background = 'linear-gradient(to right, ' + colors.join(', ') + ')';
  for (const cost of ticks(0, maxCost, 4)) {
    const tick = document.createElement('span');
    tick.textContent = cost;
    tick.style.left = 100 * cost / maxCost + '%';
    element('ticks').append(tick);
  }
  element('scale').hidden = false;
}

function setNow(time) {
  clock.now.value = Math.min(Math.max(time, 0), clock.end);
  element('now').value = clock.now.value;
  element('clock').textContent = clock.now.value.toFixed(1) + ' s of ' + clock.end.toFixed(1) + ' s';
  outcomes.forEach(placeVehicles);
  requestFrame();
}

// Playing starts over when all has been seen.
function play() {
  clock.last = clock.last === undefined ? performance.now() : undefined;
  element('play').textContent = clock.last === undefined ? 'Play' : 'Pause';
  if (clock.last !== undefined && clock.now.value >= clock.end) setNow(0);
  requestFrame();
}

function advance(time) {
  if (clock.last === undefined) return;
  const passed = Math.max(0, time - clock.last) / 1000;
  clock.last = time;
  setNow(clock.now.value + passed * Number(element('speed').value));
  if (clock.now.value >= clock.end) play();
}

// --- camera and frames ------------------------------------------------------------------------------------------------

const renderer = new THREE.WebGLRenderer({ antialias: true });
renderer.setClearColor(0xffffff);
renderer.setPixelRatio(window.devicePixelRatio);
element('view').append(renderer.domElement);
const camera = new THREE.PerspectiveCamera(FIELD_OF_VIEW * 180 / Math.PI, 1, 0.01 * length, 100 * length);
camera.up.set(0, 0, 1);
const orbit = new THREE.OrbitControls(camera, renderer.domElement);
const cut = new THREE.Plane(new THREE.Vector3(0, 0, -1), 0);

function lookFrom(x, y, z) {
  const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((i) => new THREE.Vector3(
    bounds[i & 1 ? 'max' : 'min'].x, bounds[i & 2 ? 'max' : 'min'].y, bounds[i & 4 ? 'max' : 'min'].z));
  const direction = new THREE.Vector3(x, y, z).normalize();
  const right = new THREE.Vector3().crossVectors(camera.up, direction).normalize();
  const up = new THREE.Vector3().crossVectors(direction, right);
  const tangent = Math.tan(0.5 * FIELD_OF_VIEW), margin = 1.2;
  let distance = 0;  // from which every corner is in sight
  for (const corner of corners) {
    const c = corner.sub(center);
    const aside = Math.max(Math.abs(c.dot(up)), Math.abs(c.dot(right)) / camera.aspect);
    distance = Math.max(distance, margin * aside / tangent + c.dot(direction));
  }
  camera.position.copy(center).addScaledVector(direction, distance);
  orbit.target.copy(center);
  orbit.update();
  requestFrame();
}

const lookHome = () => (plane ? lookFrom(-0.12, -0.75, 1) : lookFrom(-0.5, -1, 0.62));
const lookDown = () => lookFrom(0, -1e-4, 1);

function fit() {
  const height = window.innerHeight - (outcomes.length ? 64 : 0);  // the time's panel stands below
  camera.aspect = window.innerWidth / height;
  camera.updateProjectionMatrix();
  renderer.setSize(window.innerWidth, height);
  requestFrame();
}

let requested = false;
function requestFrame() {
  if (requested) return;
  requested = true;
  requestAnimationFrame((time) => {
    requested = false;
    advance(time);
    renderer.render(scene, camera);
  });
}

// Counts what is in the buffers and what the renderer has drawn of it.
function report() {
  const count = (object, per) => (object ? object.geometry.attributes.position.count / per : 0);
  const { calls, triangles, lines: segments, points } = renderer.info.render;
  root.dataset.drawn = JSON.stringify({
    boxes: count(walls.boxes, unitBox.attributes.position.count),
    cylinders: count(walls.cylinders, unitCylinder.attributes.position.count),
    vertices: count(roadmap && roadmap.points, 1),
    edges: count(roadmap && roadmap.segments, 2),
    doors: doors ? doors.children.length : 0,
    trajectories: Object.fromEntries(outcomes.map((o) => [o.name, o.vehicles.count])),
    frame: { calls, triangles, lines: segments, points },
  });
}

// --- the page ---------------------------------------------------------------------------------------------------------

const walls = makeWalls();
const frame = makeFrame();
const start = makeRegion('start', data.world.start, START);
const goal = makeRegion('goal', data.world.goal, GOAL);
const roadmap = makeRoadmap();
const path = makePath();
const doors = makeDoors();
const outcomes = data.trajectories.map(makeOutcome);

function main() {
  document.title = data.title || 'Cairn';
  element('title').textContent = data.title;
  element('subtitle').textContent = data.subtitle;
  addSlider(addSwitch('Walls', walls.group), 0.02, 1, plane ? 0.85 : 0.08, walls.setOpacity);
  if (roadmap) addSlider(addSwitch('Roadmap', roadmap.group), 0.05, 1, outcomes.length ? 0.3 : 1, roadmap.setOpacity);
  if (path) addSwitch('Optimal path, ' + data.path.length.toFixed(2) + ' m', path, PATH);
  for (const outcome of outcomes) addSwitch(outcome.ways.length + ' × ' + outcome.name, outcome.group, outcome.color);
  if (start) addSwitch('Start', start, START);
  if (goal) addSwitch('Goal', goal, GOAL);
  if (doors) addSwitch('Door numbers', doors);
  addSwitch('Grid and axes', frame);
  if (!plane) {
    renderer.clippingPlanes = [cut];
    const top = bounds.max.z + 0.1 * length;  // room for labels
    addSlider(row('Cut above'), bounds.min.z, top, top, (height) => { cut.constant = height; });
  }
  if (roadmap && data.roadmap.costs) showScale();
  if (outcomes.length) {
    clock.end = Math.max(...outcomes.map((o) => Math.max(...o.ways.map((way) => way.length - 1)))) * data.step;
    element('now').max = clock.end;
    element('now').oninput = () => setNow(Number(element('now').value));
    element('play').onclick = play;
    element('time').hidden = false;
    setNow(clock.end);
  }
  element('home').onclick = lookHome;
  element('top').onclick = lookDown;
  orbit.addEventListener('change', requestFrame);
  window.addEventListener('resize', fit);
  fit();
  lookHome();
  renderer.render(scene, camera);
  report();
}

main();
