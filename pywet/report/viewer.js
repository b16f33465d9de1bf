// Looks at runs in a page: one or more 3-D scenes with one slider, one camera and their curves. browser.py writes what it reads.
"use strict";
(() => {
  const FILM = ["#f3f7fb", "#b5d3ea", "#5b9fd0", "#1d66ac", "#08306b"];
  const SPEED = ["#440154", "#3b528b", "#21918c", "#5ec962", "#fde725"];
  const LINES = ["#0b3c78", "#d98032"];
  const BRIDGE = "#e4572e", METAL = "#9aa3ab", WALL = "#b9c4cf";
  // Spheres, bridges and wires are drawn after the translucent walls, which else would wash out the colours of what is behind them.
  const LAST = { transparent: true };
  const SCALES = {
    film: { colours: FILM, factor: 1e6, unit: "µm film" },
    speed: { colours: SPEED, factor: 1, unit: "m/s" },
  };
  const CONTROLS = `
    <div class="controls"><button type="button" class="play">play</button>
    <input type="range" class="time" min="0" step="1" value="0" aria-label="time"><output class="clock"></output>
    <label>colour <select class="by"><option value="film">film thickness</option><option value="class">size class</option>
    <option value="speed">speed</option></select></label>
    <label><input type="checkbox" class="bridges" checked> bridges</label>
    <label><input type="checkbox" class="walls" checked> walls</label>
    <button type="button" class="reset">reset view</button></div>
    <div class="stage"><div class="panels"></div><div class="charts"></div></div><div class="legend"></div>`;

  const made = (tag, parent, name = "", text = "") => {
    const element = parent.appendChild(document.createElement(tag));
    element.className = name;
    element.textContent = text;
    return element;
  };

  async function unpacked(script) {
    const run = JSON.parse(script.textContent);
    const deflated = Uint8Array.from(atob(run.data), (letter) => letter.charCodeAt(0));
    const stream = new Blob([deflated]).stream().pipeThrough(new DecompressionStream("deflate"));
    const bytes = await new Response(stream).arrayBuffer();
    for (const [name, [kind, start, length]] of Object.entries(run.arrays))
      run[name] = new globalThis[kind](bytes, start, length);
    return { ...run, data: "", name: script.dataset.name };
  }

  /** Point k of an array of rounded points, in metres. */
  const point = (run, array, k) =>
    new THREE.Vector3(...run.origin.map((middle, axis) => middle + run.quantum * array[3 * k + axis]));

  /** The last time of a run that is not later. */
  const frameAt = (run, time) => Math.max(0, run.times.findLastIndex((t) => t <= time + 1e-9));

  function between(colours, share) {
    const at = Math.min(share, 0.9999) * (colours.length - 1), k = Math.floor(at);
    return new THREE.Color(colours[k]).lerp(new THREE.Color(colours[k + 1]), at - k);
  }

  /** One run in one canvas. */
  class Panel {
    constructor(parent, camera, target, redraw) {
      const box = made("div", parent, "panel");
      this.head = made("p", box);
      this.canvas = made("canvas", box);
      this.canvas.tabIndex = 0;
      this.tip = made("div", box, "tip");
      this.tip.hidden = true;
      this.camera = camera;
      this.renderer = new THREE.WebGLRenderer({ canvas: this.canvas, antialias: true, alpha: true });
      this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
      this.controls = new THREE.OrbitControls(camera, this.canvas);
      this.controls.target = target;
      this.controls.enableZoom = false; // until one has clicked: else the wheel would not scroll the page
      this.controls.addEventListener("change", redraw);
      this.canvas.addEventListener("pointerdown", () => (this.controls.enableZoom = true));
      this.canvas.addEventListener("pointerleave", () => {
        this.controls.enableZoom = false;
        this.tip.hidden = true;
      });
      for (const kind of ["pointermove", "pointerdown"])
        this.canvas.addEventListener(kind, (event) => this.point(event.offsetX, event.offsetY));
    }

    show(run) {
      this.scene?.traverse((part) => part.geometry?.dispose());
      this.run = run;
      this.scene = new THREE.Scene();
      this.scene.add(new THREE.HemisphereLight("#ffffff", "#b0b6c0", 2.6));
      this.light = new THREE.DirectionalLight("#ffffff", 1.6);
      this.scene.add(this.light);
      const ball = new THREE.IcosahedronGeometry(1, run.id.length > 3000 ? 2 : 4);
      this.spheres = this.many(ball, new THREE.MeshPhongMaterial({ shininess: 40, specular: "#555555", ...LAST }), run.id.length);
      const most = Math.max(...run.starts.map((start, k) => start - (run.starts[k - 1] ?? 0)), 0);
      this.bridges = this.many(new THREE.BoxGeometry(), new THREE.MeshLambertMaterial({ color: BRIDGE, ...LAST }), most);
      this.walls = new THREE.Group();
      this.scene.add(this.walls);
      for (const mesh of run.meshes) this.walls.add(this.wall(mesh));
    }

    many(geometry, material, count) {
      const mesh = new THREE.InstancedMesh(geometry, material, Math.max(count, 1));
      mesh.frustumCulled = false;
      mesh.renderOrder = 1;
      this.scene.add(mesh);
      return mesh;
    }

    wall({ solid, hidden, triangles }) {
      const corners = triangles.flatMap((k) => [0, 1, 2].flatMap((n) => point(this.run, this.run.corners, 3 * k + n).toArray()));
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(corners), 3));
      geometry.computeVertexNormals();
      const look = solid ? { color: METAL, ...LAST } : { color: WALL, transparent: true, opacity: 0.14, depthWrite: false };
      const mesh = new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({ ...look, side: THREE.DoubleSide }));
      mesh.renderOrder = solid ? 1 : 0;
      if (!solid)
        mesh.add(new THREE.LineSegments(new THREE.EdgesGeometry(geometry, 25), new THREE.LineBasicMaterial({ color: "#7d8994" })));
      mesh.visible = !hidden;
      mesh.matrixAutoUpdate = false;
      return mesh;
    }

    at(time) {
      const { run } = this, frame = frameAt(run, time), count = run.id.length;
      this.frame = frame;
      this.places = [...run.id].map((_, k) => point(run, run.place, frame * count + k));
      const matrix = new THREE.Matrix4();
      this.places.forEach((place, k) => {
        const radius = run.there[frame * count + k] ? run.radius[k] : 0;
        this.spheres.setMatrixAt(k, matrix.makeScale(radius, radius, radius).setPosition(place));
      });
      this.spheres.instanceMatrix.needsUpdate = true;
      const [start, end] = this.standing();
      this.cuboids = Array.from({ length: end - start }, (_, n) => this.cuboid(start + n));
      run.meshes.forEach((mesh, k) => this.walls.children[k].matrix.set(...mesh.moved[frame], 0, 0, 0, 1));
    }

    /** First and last but one of the bridges of this time. */
    standing() {
      return [this.run.starts[this.frame] ?? 0, this.run.starts[this.frame + 1] ?? 0];
    }

    /** A bridge as the matrix of a unit box, and which wall it leads to and where. */
    cuboid(k) {
      const { run } = this, from = point(run, run.from, k), along = point(run, run.to, k).sub(from), side = run.side[k];
      const middle = from.addScaledVector(along, 0.5), helper = new THREE.Vector3(0, 0, 1);
      if (Math.abs(along.z) > 0.9 * along.length()) helper.set(1, 0, 0);
      const across = helper.cross(along).setLength(side), third = across.clone().cross(along).setLength(side);
      const matrix = new THREE.Matrix4().makeBasis(across, third, along).setPosition(middle);
      return { matrix, middle, along, atWall: run.j[k] === -1 };
    }

    /** Draws the bridges, but those to walls that one looks through from outside. */
    bind() {
      const shown = this.cuboids.filter(({ atWall, along, middle }) => !atWall || along.dot(this.camera.position.clone().sub(middle)) < 0);
      shown.forEach(({ matrix }, n) => this.bridges.setMatrixAt(n, matrix));
      this.bridges.count = shown.length;
      this.bridges.instanceMatrix.needsUpdate = true;
    }

    colour(by, most, classes) {
      const { run, frame } = this, count = run.id.length;
      for (let k = 0; k < count; k++) {
        const share = by === "class" ? 0 : (run[by][frame * count + k] / 65535) * (run[`${by}_most`] / (most || 1));
        const colour = by === "class" ? new THREE.Color(classes[run.classes[run.class[k]]]) : between(SCALES[by].colours, share);
        this.spheres.setColorAt(k, colour);
      }
      this.spheres.instanceColor.needsUpdate = true;
    }

    draw() {
      const { clientWidth: width, clientHeight: height } = this.canvas;
      this.renderer.setSize(width, height, false);
      this.camera.aspect = width / height;
      this.camera.updateProjectionMatrix();
      this.light.position.copy(this.camera.position).sub(this.controls.target).add(new THREE.Vector3(0, 0, this.run.width));
      this.bind();
      this.renderer.render(this.scene, this.camera);
    }

    /** Pixel of the canvas at which a sphere is seen. */
    where(k) {
      this.camera.updateMatrixWorld(); // else it is that of the last picture
      const seen = this.places[k].clone().project(this.camera);
      return [((seen.x + 1) / 2) * this.canvas.clientWidth, ((1 - seen.y) / 2) * this.canvas.clientHeight];
    }

    /** Says what the nearest sphere at a pixel is. */
    point(x, y) {
      const { clientWidth: width, clientHeight: height } = this.canvas, from = this.camera.position;
      this.camera.updateMatrixWorld();
      const ray = new THREE.Vector3((2 * x) / width - 1, 1 - (2 * y) / height, 0.5).unproject(this.camera).sub(from).normalize();
      let nearest = Infinity, hit = -1;
      this.places.forEach((place, k) => {
        const to = place.clone().sub(from), along = to.dot(ray);
        if (!this.run.there[this.frame * this.places.length + k] || along > nearest) return;
        if (to.lengthSq() - along ** 2 < this.run.radius[k] ** 2) [nearest, hit] = [along, k];
      });
      this.tip.hidden = hit < 0;
      if (hit < 0) return;
      this.tip.textContent = this.said(hit);
      this.tip.style.left = `${Math.min(x + 12, width - 150)}px`;
      this.tip.style.top = `${this.canvas.offsetTop + y + 12}px`;
    }

    said(k) {
      const { run, frame } = this, at = frame * run.id.length + k, partners = [];
      for (let [b, end] = this.standing(); b < end; b++) {
        if (run.i[b] === k) partners.push(run.j[b]);
        else if (run.j[b] === k) partners.push(run.i[b]);
      }
      const names = partners.map((j) => (j === -1 ? "wall" : j === -2 ? "wire" : run.id[j]));
      const film = ((1e6 * run.film_most * run.film[at]) / 65535).toFixed(1), speed = (run.speed_most * run.speed[at]) / 65535;
      const bridges = `${names.length} bridge${names.length === 1 ? "" : "s"}${names.length ? ` to ${names.join(", ")}` : ""}`;
      return `sphere ${run.id[k]}: ${run.classes[run.class[k]].replaceAll("_", " ")}, ${(2e3 * run.radius[k]).toPrecision(3)} mm; film ${film} µm; ${speed.toFixed(2)} m/s; ${bridges}`;
    }
  }

  /** Ticks from 0 up to a value, at most so many steps of 1, 2 or 5 times a power of ten. */
  function ticks(most, steps) {
    if (!(most > 0)) return [0, 1];
    const power = 10 ** Math.floor(Math.log10(most / steps)), step = power * [1, 2, 5, 10].find((unit) => most <= steps * unit * power * 1.5);
    return Array.from({ length: Math.floor(most / step + 1e-9) + 1 }, (_, k) => +(k * step).toPrecision(6));
  }

  /** Curves of one quantity as a picture; returns what moves their dots. */
  function chart(parent, quantity, runs) {
    const curves = runs.map((run) => run.curves.find((curve) => curve.quantity === quantity)).filter(Boolean), [{ title }] = curves;
    const last = Math.max(...curves.flatMap((c) => c.x)), most = Math.max(...curves.flatMap((c) => c.y));
    const times = ticks(last, 4), values = ticks(most, 4), right = Math.max(last, times.at(-1)), top = Math.max(most, values.at(-1));
    const x = (t) => 34 + (180 * t) / right, y = (v) => 122 - (96 * v) / top;
    const text = (at, said, anchor) => `<text x="${at[0]}" y="${at[1]}" text-anchor="${anchor}" font-size="11" fill="#27323d">${said}</text>`;
    const along = times.map((t) => `<path d="M${x(t)} 122v4" stroke="#aab3bb"/>${text([x(t), 137], t, "middle")}`).join("");
    const up = values.map((v) => `<path d="M34 ${y(v)}H214" stroke="#e1e6eb"/>${text([30, y(v) + 4], v, "end")}`).join("");
    const figure = made("div", parent);
    figure.innerHTML = `<svg viewBox="0 0 226 154" role="img">${up}<path d="M34 22V122H214" fill="none" stroke="#aab3bb"/>
      ${text([2, 12], title, "start")}${along}${text([124, 151], "time in s", "middle")}</svg>`;
    const svg = figure.firstChild, part = (tag, values) => {
      const element = svg.appendChild(document.createElementNS(svg.namespaceURI, tag));
      for (const [name, value] of Object.entries(values)) element.setAttribute(name, value);
      return element;
    };
    svg.setAttribute("aria-label", `${title} over time`);
    const dots = curves.map((curve, k) => {
      const points = curve.x.map((t, n) => `${x(t).toFixed(1)},${y(curve.y[n]).toFixed(1)}`).join(" ");
      part("polyline", { points, fill: "none", stroke: LINES[k % LINES.length], "stroke-width": 2 });
      return part("circle", { r: 4, fill: LINES[k % LINES.length], stroke: "#ffffff" });
    });
    return (time) => curves.forEach((curve, k) => {
      const n = Math.max(0, curve.x.findLastIndex((t) => t <= time + 1e-9));
      dots[k].setAttribute("cx", x(curve.x[n]));
      dots[k].setAttribute("cy", y(curve.y[n]));
    });
  }

  async function start(root) {
    const scripts = [...root.querySelectorAll("script.run")];
    root.insertAdjacentHTML("afterbegin", CONTROLS);
    const find = (name) => root.querySelector(`.${name}`), slider = find("time");
    const camera = new THREE.PerspectiveCamera(35, 1, 1e-3, 100), target = new THREE.Vector3();
    const first = await unpacked(scripts[0]);
    camera.up.set(...first.up);
    let moves = [], times = [], waiting = false, playing = 0;
    const redraw = () => {
      if (!waiting) requestAnimationFrame(() => ((waiting = false), panels.forEach((panel) => panel.draw())));
      waiting = true;
    };
    const panels = [], classes = JSON.parse(root.dataset.classes);
    const legend = (by, most) => {
      const place = find("legend"), line = (look, name, said) => {
        const entry = made("span", place);
        made("i", entry, name).style.background = look;
        entry.append(said);
        return entry;
      };
      place.textContent = "";
      if (by === "class") new Set(panels.flatMap(({ run }) => run.classes)).forEach((name) => line(classes[name], "", name.replaceAll("_", " ")));
      else {
        const { colours, factor, unit } = SCALES[by];
        line(`linear-gradient(90deg, ${colours})`, "bar", `${(factor * most).toPrecision(3)} ${unit}`).prepend("0");
      }
      line(BRIDGE, "", "liquid bridges");
      made("span", place, "", "drag: turn; click, then wheel: zoom; point at a sphere");
    };
    const tell = () => {
      const time = times[+slider.value], by = find("by").value;
      const most = by === "class" ? 0 : Math.max(...panels.map((panel) => panel.run[`${by}_most`]));
      find("clock").textContent = `t = ${time.toFixed(3)} s`;
      for (const panel of panels) {
        panel.at(time);
        panel.colour(by, most, classes);
        panel.bridges.visible = find("bridges").checked;
        panel.walls.visible = find("walls").checked;
        panel.tip.hidden = true;
      }
      moves.forEach((move) => move(time));
      legend(by, most);
      redraw();
    };
    const reset = () => {
      const { middle, camera: place, width } = panels[0].run;
      target.set(...middle);
      camera.position.set(...place);
      camera.near = width / 100;
      camera.far = 100 * width;
      panels.forEach((panel) => panel.controls.update());
      redraw();
    };
    const begin = () => {
      const shown = times[+slider.value] ?? panels[0].run.telling; // at first when about a third has passed
      const runs = panels.map((panel) => panel.run);
      times = [...new Set(runs.flatMap((run) => run.times))].sort((a, b) => a - b);
      slider.max = times.length - 1;
      slider.value = times.findLastIndex((time) => time <= Math.max(shown, runs[0].times[0]));
      find("charts").textContent = "";
      moves = [...new Set(runs.flatMap((run) => run.curves.map((c) => c.quantity)))].map((quantity) => chart(find("charts"), quantity, runs));
      tell();
    };
    for (let k = 0; k < Math.min(+root.dataset.panels, scripts.length); k++) {
      const panel = new Panel(find("panels"), camera, target, redraw);
      panel.show(k ? await unpacked(scripts[k]) : first);
      panels.push(panel);
      const choice = made("select", panel.head);
      scripts.forEach((script) => made("option", choice, "", script.dataset.name));
      choice.selectedIndex = k;
      choice.setAttribute("aria-label", "run");
      panel.head.style.borderBottom = root.dataset.panels > 1 ? `3px solid ${LINES[k % LINES.length]}` : "";
      choice.addEventListener("change", async () => {
        panel.show(await unpacked(scripts[choice.selectedIndex]));
        begin();
      });
    }
    root.panels = panels;
    for (const name of ["time", "by", "bridges", "walls"]) find(name).addEventListener("input", tell);
    find("reset").addEventListener("click", reset);
    find("play").addEventListener("click", () => {
      clearInterval(playing);
      const going = find("play").textContent === "play";
      find("play").textContent = going ? "stop" : "play";
      if (going) playing = setInterval(() => ((slider.value = (+slider.value + 1) % times.length), tell()), 150);
    });
    if (panels.every((panel) => !panel.run.film_most)) find("by").value = "class";
    begin();
    reset();
    new ResizeObserver(redraw).observe(root);
    root.dataset.ready = "yes";
  }

  for (const root of document.querySelectorAll(".viewer")) {
    const seen = new IntersectionObserver((entries) => {
      if (!entries.some((entry) => entry.isIntersecting)) return;
      seen.disconnect();
      start(root).catch((error) => made("p", root, "", `This browser cannot draw the scene: ${error.message}`));
    });
    seen.observe(root);
  }
})();
