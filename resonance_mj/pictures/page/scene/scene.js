// The motion of a run as a scene to turn and to scrub, and a cursor at the same time in the figures; or live, as
// the server sends it.
// Its data are written by ../scene.py; MuJoCo's frame has z upwards, and quaternions (w, x, y, z).
import {
  BoxGeometry, BufferAttribute, BufferGeometry, CanvasTexture, CapsuleGeometry, CircleGeometry, Color,
  CylinderGeometry, DirectionalLight, DoubleSide, Fog, Group, HemisphereLight, Mesh, MeshLambertMaterial, PCFShadowMap, PerspectiveCamera, PlaneGeometry, Quaternion, RepeatWrapping, Scene, SphereGeometry, SRGBColorSpace,
  Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

const PALETTE = { tool: "#0072B2", motor: "#AA3377", negative: "#E69F00", zero: "#C4C4C4", positive: "#009E73" };
const SIDES = 8, WINDINGS = 2, SWEEP = 1.5 * Math.PI, WEAK = 0.02, RINGS = { spring: 110, motor: 36, trail: 48, mark: 4 };

const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)).buffer;
const floats = (text) => new Float32Array(bytes(text));
const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
const vector = (array, at = 0) => new Vector3(array[at], array[at + 1], array[at + 2]);
const quaternion = (array, at = 0) => new Quaternion(array[at + 1], array[at + 2], array[at + 3], array[at]);
const clock = (seconds) => `${seconds.toFixed(2)} s`;

/** A curve as a tube whose centre line and radius are rewritten. */
class Tube {
  constructor(parent, rings, colour) {
    this.rings = rings;
    const geometry = new BufferGeometry(), faces = [];
    for (let ring = 0; ring + 1 < rings; ring++) {
      for (let side = 0; side < SIDES; side++) {
        const a = ring * SIDES + side, b = ring * SIDES + ((side + 1) % SIDES);
        faces.push(a, b, b + SIDES, a, b + SIDES, a + SIDES);
      }
    }
    geometry.setIndex(faces);
    for (const name of ["position", "normal"]) {
      geometry.setAttribute(name, new BufferAttribute(new Float32Array(3 * rings * SIDES), 3));
    }
    this.material = new MeshLambertMaterial({ color: colour, side: DoubleSide });
    this.mesh = new Mesh(geometry, this.material);
    this.mesh.frustumCulled = false;
    this.mesh.castShadow = true;
    parent.add(this.mesh);
  }

  /** point(part) and radius(part) along the tube; `normal` is a direction that it nowhere runs along. */
  bend(point, radius, normal) {
    const { position, normal: normals } = this.mesh.geometry.attributes, { rings } = this;
    const points = Array.from({ length: rings }, (_, ring) => point(ring / (rings - 1)));
    const along = new Vector3(), u = new Vector3(), v = new Vector3(), out = new Vector3();
    for (let ring = 0; ring < rings; ring++) {
      along.subVectors(points[Math.min(ring + 1, rings - 1)], points[Math.max(ring - 1, 0)]);
      u.crossVectors(along, normal).normalize();
      v.crossVectors(along, u).normalize();
      const wide = radius(ring / (rings - 1), ring);
      for (let side = 0; side < SIDES; side++) {
        const angle = (2 * Math.PI * side) / SIDES, at = ring * SIDES + side;
        out.copy(u).multiplyScalar(Math.cos(angle)).addScaledVector(v, Math.sin(angle));
        normals.setXYZ(at, out.x, out.y, out.z);
        out.multiplyScalar(wide).add(points[ring]);
        position.setXYZ(at, out.x, out.y, out.z);
      }
    }
    position.needsUpdate = normals.needsUpdate = true;
    this.mesh.visible = true;
  }
}

const rounded = (radius) => (part) => (part === 0 || part === 1 ? 0 : radius);
const dashed = (radius, dash) => (_, ring) => (Math.floor(ring / dash) % 2 ? 0 : radius);
const arrow = (radius, head) => (part) => (part === 0 ? 0 : part > 1 - head ? (2.8 * radius * (1 - part)) / head : radius);

function shape(geom, meshes) {
  const [a, b, c] = geom.size;
  switch (geom.kind) {
    case "sphere": return new SphereGeometry(a, 32, 20);
    case "capsule": return new CapsuleGeometry(a, 2 * b, 10, 28).rotateX(Math.PI / 2);
    case "cylinder": return new CylinderGeometry(a, a, 2 * b, 40).rotateX(Math.PI / 2);
    case "ellipsoid": return new SphereGeometry(1, 32, 20).scale(a, b, c);
    case "box": return new BoxGeometry(2 * a, 2 * b, 2 * c);
    case "plane": return new PlaneGeometry(2 * a || 40, 2 * b || 40);
    default: return meshes[geom.mesh];
  }
}

function mesh({ low, wide, corners, faces }) {
  const steps = new Uint16Array(bytes(corners)), place = new Float32Array(steps.length);
  steps.forEach((step, at) => (place[at] = low[at % 3] + (wide[at % 3] * step) / 65535));
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(place, 3));
  geometry.setIndex(new BufferAttribute(new Uint32Array(bytes(faces)), 1));
  // Faces of their own corners: edges stay edges.
  const apart = geometry.toNonIndexed();
  apart.computeVertexNormals();
  return apart;
}

function checker() {
  const canvas = Object.assign(document.createElement("canvas"), { width: 64, height: 64 });
  const paint = canvas.getContext("2d");
  paint.fillStyle = "#fff";
  paint.fillRect(0, 0, 64, 64);
  paint.fillStyle = "#e6e6e6";
  paint.fillRect(0, 0, 32, 32);
  paint.fillRect(32, 32, 32, 32);
  const texture = new CanvasTexture(canvas);
  texture.wrapS = texture.wrapT = RepeatWrapping;
  texture.colorSpace = SRGBColorSpace;
  texture.anisotropy = 8;
  return texture;
}

/** A figure's cursor: a line in each panel that has a time axis, and a click that goes to its time. */
function cursors(go) {
  const figures = [];
  for (const svg of document.querySelectorAll("svg[data-time]")) {
    const panels = JSON.parse(svg.dataset.time).map(([begin, end, left, right, top, bottom]) => {
      const line = document.createElementNS("http://www.w3.org/2000/svg", "line");
      line.setAttribute("class", "cursor");
      line.setAttribute("y1", top);
      line.setAttribute("y2", bottom);
      svg.append(line);
      return { begin, end, left, right, top, bottom, line };
    });
    const seek = (event) => {
      const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
      const panel = panels.find((one) => at.x >= one.left && at.x <= one.right && at.y >= one.top && at.y <= one.bottom);
      if (panel) go(panel.begin + ((at.x - panel.left) / (panel.right - panel.left)) * (panel.end - panel.begin));
    };
    svg.addEventListener("pointerdown", seek);
    svg.addEventListener("pointermove", (event) => event.buttons && seek(event));
    figures.push(...panels);
  }
  return (time) => {
    for (const { begin, end, left, right, line } of figures) {
      const inside = time >= begin && time <= end;
      line.setAttribute("visibility", inside ? "visible" : "hidden");
      const x = left + ((time - begin) / (end - begin)) * (right - left);
      line.setAttribute("x1", x);
      line.setAttribute("x2", x);
    }
  };
}

function begin(root) {
  const data = JSON.parse(document.getElementById(root.dataset.scene).textContent);
  const canvas = root.querySelector("canvas"), slider = root.querySelector("input");
  const button = root.querySelector("button.play"), reading = root.querySelector("output");
  const many = data.bodies.length, n = data.joints.length, { size, live } = data;
  const widths = { times: 1, poses: 7 * many, tool: 3, stiffness: n, away: n, spring: n, motor: n, error: 1 };
  const rows = Object.fromEntries(Object.entries(widths).map(([name, width]) =>
    [name, live ? new Float32Array(live * width) : floats(data[name])]));
  const { times, poses, tool, stiffness, away, spring, motor, error } = rows, frames = times.length;
  if (live) Object.assign(data, { path: new Array(frames).fill(0), trail: [0], cycle: [] });

  if (!document.createElement("canvas").getContext("webgl2")) throw new Error("it has no WebGL 2");
  const renderer = new WebGLRenderer({ canvas, antialias: true, powerPreference: "low-power" });
  renderer.shadowMap.enabled = true;
  renderer.shadowMap.type = PCFShadowMap;
  const scene = new Scene(), target = vector(data.camera.target), eye = vector(data.camera.eye);
  const far = eye.distanceTo(target), camera = new PerspectiveCamera(data.camera.fov, 16 / 9, far / 100, far * 40);
  camera.up.set(0, 0, 1);
  camera.position.copy(eye);
  const controls = new OrbitControls(camera, canvas);
  controls.target.copy(target);
  controls.enableDamping = true;
  controls.update();
  scene.add(new HemisphereLight(0xffffff, 0xa4a8b0, 1.9));
  const sun = new DirectionalLight(0xffffff, 1.7);
  sun.position.copy(target).add(new Vector3(-0.7 * far, -1.2 * far, 1.8 * far));
  sun.target.position.copy(target);
  sun.castShadow = true;
  sun.shadow.mapSize.set(1024, 1024);
  Object.assign(sun.shadow.camera, { left: -far, right: far, top: far, bottom: -far, near: far / 10, far: 6 * far });
  sun.shadow.bias = -0.0005;
  sun.shadow.normalBias = 0.01 * size;
  scene.add(sun, sun.target);

  const meshes = data.meshes.map(mesh), floors = [];
  const bodies = data.bodies.map((geoms) => {
    const body = new Group();
    for (const geom of geoms) {
      const [r, g, b, opacity] = geom.colour, flat = geom.kind === "plane";
      const material = new MeshLambertMaterial({ transparent: opacity < 1, opacity });
      material.color.setRGB(r, g, b, SRGBColorSpace);
      const one = new Mesh(shape(geom, meshes), material);
      // A floor has no edge: it ends in the haze.
      if (flat && new Vector3(0, 0, 1).applyQuaternion(quaternion(geom.turn)).z > 0.99) {
        const round = new CircleGeometry(10 * far, 48), { uv, position: at } = round.attributes;
        for (let i = 0; i < uv.count; i++) uv.setXY(i, at.getX(i) / (6 * size), at.getY(i) / (6 * size));
        material.map = checker();
        one.geometry = round;
        floors.push(material);
      }
      one.position.copy(vector(geom.at));
      one.quaternion.copy(quaternion(geom.turn));
      one.castShadow = !flat && opacity === 1;
      one.receiveShadow = true;
      body.add(one);
    }
    scene.add(body);
    return body;
  });
  const overlays = data.joints.map(() => ({
    spring: new Tube(scene, RINGS.spring, PALETTE.zero),
    mark: new Tube(scene, RINGS.mark, "#1a1a1a"),
    motor: new Tube(scene, RINGS.motor, PALETTE.motor),
  }));
  const trail = new Tube(scene, RINGS.trail, PALETTE.tool);
  const along = (path, points) => {
    const places = points.map((point) => vector(point));
    path.bend((part) => places[Math.round(part * (places.length - 1))], dashed(0.035 * size, 3), flattest(places));
    return path;
  };
  const paths = live ? [new Tube(scene, live, "#1a1a1a")]
    : data.paths.map((points) => along(new Tube(scene, points.length, "#1a1a1a"), points));

  const dark = matchMedia("(prefers-color-scheme: dark)");
  const sky = () => {
    const paper = new Color(dark.matches ? "#20242b" : "#e9edf1"), ink = dark.matches ? "#f2f2f2" : "#1a1a1a";
    scene.background = paper;
    scene.fog = new Fog(paper, 1.5 * far, 6 * far);
    for (const floor of floors) floor.color.set(dark.matches ? "#3a4048" : "#d3d8de");
    for (const one of [...paths, ...overlays.map(({ mark }) => mark)]) one.material.color.set(ink);
    stale = true;
  };

  const span = (frame) => data.spans.findIndex(([, , first], i) => frame >= first && frame < (data.spans[i + 1]?.[2] ?? frames));
  let now = 0, playing = false, stale = true, drawn = 0;
  const between = (values, width, at, i) => {
    const low = Math.floor(at), high = span(low) === span(low + 1) ? Math.min(low + 1, frames - 1) : low, part = at - low;
    return values[low * width + i] * (1 - part) + values[high * width + i] * part;
  };
  const turn = new Quaternion(), next = new Quaternion(), shade = new Color(), end = new Color();

  function show(at) {
    const low = Math.floor(at), high = span(low) === span(low + 1) ? Math.min(low + 1, frames - 1) : low;
    bodies.forEach((body, i) => {
      body.position.set(...[0, 1, 2].map((k) => between(poses, 7 * many, at, 7 * i + k)));
      turn.copy(quaternion(poses, 7 * (low * many + i) + 3));
      body.quaternion.copy(turn.slerp(next.copy(quaternion(poses, 7 * (high * many + i) + 3)), at - low));
    });
    data.joints.forEach((joint, j) => {
      const body = bodies[joint.body], on = overlays[j], turned = body.quaternion;
      const anchor = vector(joint.anchor).applyQuaternion(turned).add(body.position);
      const axis = vector(joint.axis).applyQuaternion(turned), link = vector(joint.link).applyQuaternion(turned);
      const across = new Vector3().crossVectors(axis, link);
      const around = (angle) => link.clone().multiplyScalar(Math.cos(angle)).addScaledVector(across, Math.sin(angle));
      const share = between(stiffness, n, at, j), strength = Math.min(Math.abs(share), 1);
      const most = joint.slides ? 4 * size : 2 * Math.PI, wanted = between(away, n, at, j), stop = clamp(wanted, -most, most);
      const centre = anchor.clone().addScaledVector(axis, joint.lift), radius = 0.09 * size * Math.sqrt(strength);
      const profile = share > 0 ? rounded(radius) : dashed(radius, 4);
      on.spring.mesh.visible = on.mark.mesh.visible = on.motor.mesh.visible = false;
      if (strength >= WEAK && joint.slides) {
        const side = anchor.clone().addScaledVector(link, joint.outer);
        const coil = (angle) => link.clone().multiplyScalar(Math.cos(angle)).addScaledVector(across, Math.sin(angle)).multiplyScalar(0.35 * size);
        on.spring.bend((part) => side.clone().add(coil(12 * Math.PI * part)).addScaledVector(axis, stop * part), profile, axis);
        on.mark.bend((part) => side.clone().addScaledVector(axis, stop).addScaledVector(across, size * (1.2 * part - 0.6)), rounded(0.07 * size), axis);
      } else if (strength >= WEAK) {
        on.spring.bend(
          (part) => around((stop - 2 * Math.PI * WINDINGS) * part)
            .multiplyScalar(joint.inner + (joint.outer - joint.inner) * part)
            .addScaledVector(axis, 0.15 * size * part * (Math.sign(joint.lift) || 1)).add(centre),
          profile, axis,
        );
        const reach = (part) => joint.outer + size * (0.5 * part - 0.1);
        on.mark.bend((part) => around(stop).multiplyScalar(reach(part)).add(centre), rounded(0.07 * size), axis);
      }
      on.mark.mesh.visible &&= Math.abs(wanted) <= most;
      const carried = between(spring, n, at, j);
      shade.set(PALETTE.zero).lerp(end.set(carried > 0 ? PALETTE.positive : PALETTE.negative), Math.min(Math.abs(carried), 1));
      on.spring.material.color.copy(shade);
      const torque = clamp(between(motor, n, at, j), -1, 1);
      if (Math.abs(torque) >= WEAK) {
        const wide = joint.outer + 0.45 * size;
        const length = joint.slides ? 3 * size * Math.abs(torque) : SWEEP * Math.abs(torque) * wide;
        const head = clamp((0.35 * size) / length, 0.1, 0.5);
        const from = anchor.clone().addScaledVector(link, -joint.outer);
        const line = joint.slides
          ? (part) => from.clone().addScaledVector(axis, 3 * size * torque * part)
          : (part) => around(SWEEP * torque * part).multiplyScalar(wide).add(centre);
        on.motor.bend(line, arrow(0.075 * size, head), joint.slides ? link : axis);
      }
    });
    paths.forEach((path, i) => (path.mesh.visible = i === data.path[low]));
    const first = Math.max(data.spans[span(low)][2], at - data.trail[data.path[low]]);
    const passed = Array.from({ length: RINGS.trail }, (_, ring) => first + ((at - first) * ring) / (RINGS.trail - 1));
    const places = passed.map((frame) => new Vector3(...[0, 1, 2].map((k) => between(tool, 3, frame, k))));
    trail.mesh.visible = false;
    if (at - first > 1) {
      trail.bend((part) => places[Math.round(part * (RINGS.trail - 1))], (part) => 0.075 * size * part, flattest(places));
    }
    if (live) {
      stale = true;
      return;
    }
    const time = between(times, 1, at, 0);
    slider.value = at;
    slider.setAttribute("aria-valuetext", clock(time));
    reading.textContent = `${clock(time)} · cycle ${data.cycle[low]} · ${(1e3 * error[low]).toFixed(error[low] < 0.001 ? 3 : 1)} mm off`;
    point(time);
    stale = true;
  }

  const go = (time) => {
    // The nearest frame: times between spans were not kept.
    let nearest = 0;
    times.forEach((other, frame) => { if (Math.abs(other - time) < Math.abs(times[nearest] - time)) nearest = frame; });
    play(false);
    show((now = nearest));
  };
  const point = cursors(go);
  function play(on) {
    if (playing !== on) fit((playing = on));
    button.textContent = on ? "Pause" : "Play";
    button.setAttribute("aria-pressed", on);
  }
  // Without a graphics processor: fewer pixels, and then no shadows, until it moves.
  let before = 0, slow = 0, sharpness = Math.min(devicePixelRatio, 2);
  function lighten() {
    slow = 0;
    if (sharpness > 0.5) sharpness = Math.max(0.5, sharpness / 1.5);
    else renderer.shadowMap.enabled = sun.castShadow = false;
    fit();
  }
  function tick(moment) {
    const took = moment - before, passed = Math.min(took, 100) / 1000;
    before = moment;
    slow = playing && took > 50 && took < 1000 ? slow + 1 : Math.max(0, slow - 0.5);
    if (slow > 4 && sun.castShadow) lighten();
    if (playing) show((now = (now + data.fps * passed) % frames));
    if (controls.update() || stale) {
      renderer.render(scene, camera);
      canvas.dataset.drawn = ++drawn;
      stale = false;
    }
  }
  function fit() {
    const { clientWidth: width, clientHeight: height } = canvas;
    renderer.setPixelRatio(playing ? sharpness : Math.min(devicePixelRatio, 2));
    renderer.setSize(width, height, false);
    camera.aspect = width / height;
    // What fits into a wide picture shall fit into a narrow one.
    camera.fov = (2 * 180 * Math.atan(Math.tan((data.camera.fov * Math.PI) / 360) * Math.max(1, 1.6 / camera.aspect))) / Math.PI;
    camera.updateProjectionMatrix();
    stale = true;
  }
  new ResizeObserver(fit).observe(canvas);
  dark.addEventListener("change", sky);
  root.querySelector("button.home").addEventListener("click", () => {
    camera.position.copy(eye);
    controls.target.copy(target);
  });
  root.querySelectorAll("button[data-frame]").forEach((one) => one.addEventListener("click", () => show((now = Number(one.dataset.frame)))));
  sky();
  fit();
  if (live) {
    watch();
  } else {
    button.addEventListener("click", () => play(!playing));
    slider.max = frames - 1;
    slider.addEventListener("input", () => { play(false); show((now = Number(slider.value))); });
    show(0);
    document.body.classList.add("timed");
  }
  root.classList.add("ready");
  // Drawn only where it can be seen.
  new IntersectionObserver(([entry]) => renderer.setAnimationLoop(entry.isIntersecting ? tick : null)).observe(canvas);
  if (!live) play(!matchMedia("(prefers-reduced-motion: reduce)").matches);

  /** Frames as they come from the server; the last of them is shown. */
  function watch() {
    const source = new EventSource("frames");
    let starts = 0, drawnAlong = "";
    source.onmessage = (message) => {
      const frame = JSON.parse(message.data), again = frame.starts !== starts;
      starts = frame.starts;
      for (const [name, width] of Object.entries(widths)) {
        const row = [frame[name]].flat();
        if (again) for (let i = 0; i < frames; i++) rows[name].set(row, i * width);
        rows[name].copyWithin(0, width);
        rows[name].set(row, (frames - 1) * width);
      }
      const path = JSON.stringify(frame.path ?? []);
      if (frame.path && path !== drawnAlong) along(paths[0], frame.path);
      drawnAlong = path;
      data.trail[0] = frame.trail ?? 0;
      reading.textContent = frame.said;
      show(frames - 1);
      root.dataset.shown = Number(root.dataset.shown ?? 0) + 1;
    };
    source.addEventListener("end", () => {
      source.close();
      reading.textContent += " · the viewer has ended";
    });
    for (const one of root.querySelectorAll("button[data-press]")) {
      one.addEventListener("click", () => fetch(`press/${one.dataset.press}`, { method: "POST" }));
    }
  }
}

/** A direction across which points hardly spread: a tube's normal. */
function flattest(points) {
  const a = points[0], b = points[Math.floor(points.length / 3)], c = points[Math.floor((2 * points.length) / 3)];
  const normal = new Vector3().crossVectors(new Vector3().subVectors(b, a), new Vector3().subVectors(c, a));
  if (normal.length() > 1e-9) return normal.normalize();
  const along = new Vector3().subVectors(b, a);
  return Math.abs(along.z) > Math.abs(along.x) ? new Vector3(1, 0, 0) : new Vector3(0, 0, 1);
}

for (const root of document.querySelectorAll("[data-scene]")) {
  try {
    begin(root);
  } catch (failure) {
    root.classList.add("failed");
    root.querySelector(".failure").textContent = `This browser draws no scene: ${failure.message}`;
  }
}
