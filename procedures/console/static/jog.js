// A bench from a browser. Nothing here keeps anything safe: the bench stops what this page does not answer for in time.
"use strict";
(() => {
  const one = (id) => document.getElementById(id);
  const bench = one("bench"), said = one("said"), take = one("take"), give = one("give"), stop = one("stop"), fresh = one("fresh");
  const sensors = JSON.parse(bench.dataset.sensors), rig = encodeURIComponent(bench.dataset.rig);
  let socket = null, me = "", isMine = false, tick = 0, press = 0, held = null, heard = performance.now(), pause = 500, view = null, number = 0, isTrying = true;

  const say = (text, isRefused = false) => {
    said.textContent = text;
    said.classList.toggle("refused", isRefused);
  };
  const send = (order) => {
    if (!socket || socket.readyState !== WebSocket.OPEN) return false;
    socket.send(JSON.stringify(order));
    return true;
  };
  const beat = (more = {}) => send({ say: "beat", tick, press, held, ...more });
  const order = (act, axis, degrees) => {
    if (!send({ say: "do", act, axis, degrees, tick })) say("not connected; nothing moved", true);
  };

  // Stop: by the socket and, for when that is not heard, by a request of its own. Both mean the same and count as often as they come.
  const halt = () => {
    let_go();
    send({ say: "stop" });
    number += 1;
    if (stop) postAct(stop, "stop", `${stop.elements.key.value}-${number}`, say);
  };
  if (stop) {
    stop.addEventListener("pointerdown", (event) => { event.preventDefault(); halt(); });
    stop.addEventListener("submit", (event) => { event.preventDefault(); halt(); });
  }
  window.addEventListener("keydown", (event) => { if (event.key === "Escape") { event.preventDefault(); halt(); } });

  // Hold to move: the button says it is held in every beat, and says at once when it is let go.
  const grip = (button, axis, rate) => {
    if (held || !isMine) return let_go();
    press += 1;
    held = { axis, rate_dps: Number(button.dataset.way) * rate };
    button.classList.add("held");
    beat();
  };
  const let_go = () => {
    if (!held) return;
    held = null;
    document.querySelectorAll(".hold.held").forEach((button) => button.classList.remove("held"));
    beat();
  };
  const leave = () => {  // who looks elsewhere moves nothing
    let_go();
    if (isMine) beat({ away: true });
  };
  for (const kind of ["pointerup", "pointercancel", "touchend", "touchcancel"]) window.addEventListener(kind, let_go);
  window.addEventListener("keyup", let_go);
  window.addEventListener("blur", leave);
  window.addEventListener("pagehide", leave);
  document.addEventListener("visibilitychange", () => { if (document.hidden) leave(); });
  document.addEventListener("contextmenu", (event) => { if (event.target.closest(".hold")) event.preventDefault(); });

  const cards = new Map();
  const card = (axis) => {
    if (cards.has(axis.name)) return cards.get(axis.name);
    const node = one("axis").content.firstElementChild.cloneNode(true), find = (what) => node.querySelector(what);
    find("h3").textContent = axis.name;
    const [low, high] = axis.limits_deg, field = find(".goto input"), size = find(".size"), rate = find(".rate");
    const range = `${low} to ${high}°`.replaceAll("-", "−");
    find(".goto .pick span").textContent = `Go to, ${range}`;
    const options = (place, values, chosen) => values.forEach((value) => place.add(new Option(value, value, false, value === chosen)));
    options(size, axis.steps_deg, axis.steps_deg.includes(1) ? 1 : axis.steps_deg[0]);
    const top = axis.top_rate_dps;
    find(".turn").hidden = !(top > 0);
    options(rate, [0.1, 0.5, 1, 2, 5, 10, 20, 50].filter((value) => value < top).concat(top > 0 ? [top] : []), top > 1 ? 1 : top);
    node.querySelectorAll("button").forEach((button) => button.setAttribute("aria-label", `${axis.name}: ${button.textContent}`));
    rate.setAttribute("aria-label", `${axis.name}: rate, degrees a second`);
    size.setAttribute("aria-label", `${axis.name}: size of a step, degrees`);
    node.querySelectorAll(".hold").forEach((button) => {
      button.addEventListener("pointerdown", (event) => {
        if (event.button) return;
        grip(button, axis.name, Number(rate.value));
      });
      button.addEventListener("lostpointercapture", let_go);
      button.addEventListener("pointerleave", let_go);
      button.addEventListener("keydown", (event) => {
        if (event.repeat || (event.key !== " " && event.key !== "Enter")) return;
        event.preventDefault();
        grip(button, axis.name, Number(rate.value));
      });
      button.addEventListener("blur", let_go);
    });
    node.querySelectorAll("[data-act=step]").forEach((button) => button.addEventListener("click", () => order("step", axis.name, Number(button.dataset.way) * Number(size.value))));
    find("[data-act=home]").addEventListener("click", () => order("home", axis.name));
    find(".goto").addEventListener("submit", (event) => {
      event.preventDefault();
      const text = field.value.trim().replace("−", "-").replace(",", "."), degrees = Number(text);
      if (text === "" || !Number.isFinite(degrees)) say(`${axis.name}: got "${field.value}", allowed is a number; nothing moved`, true);
      else if (degrees < low || degrees > high) say(`${axis.name}: got ${degrees}°, allowed are ${range}; nothing moved`, true);
      else order("goto", axis.name, degrees);
    });
    one("axes").append(node);
    cards.set(axis.name, node);
    return node;
  };

  const signed = (value, digits) => `${value < 0 ? "−" : "+"}${Math.abs(value).toFixed(digits)}`;
  const put = (node, text) => { if (node.textContent !== text) node.textContent = text; };
  const show = () => {
    bench.hidden = false;
    for (const axis of view.axes) {
      const node = card(axis), trouble = axis.silence || axis.fault || (axis.is_homed ? "" : "not homed: its position is not known");
      put(node.querySelector("b"), axis.position_deg === null ? "—" : `${signed(axis.position_deg, 4)}°`);
      const moves = axis.is_moving ? (axis.rate_dps === null ? "moves" : `turns at ${axis.rate_dps.toPrecision(4)}°/s`) : "at rest";
      put(node.querySelector(".where span"), trouble || (axis.target_deg === null ? moves : `${moves}, to ${axis.target_deg}°`));
      node.classList.toggle("moving", axis.is_moving);
      node.classList.toggle("lost", Boolean(trouble));
    }
    read();
    const news = one("news");
    const key = JSON.stringify(view.messages);
    if (news.dataset.key !== key) {
      news.dataset.key = key;
      news.replaceChildren(...[...view.messages].reverse().map(([clock, tone, text]) => {
        const line = document.createElement("li"), time = document.createElement("time");
        time.textContent = clock;
        line.className = tone;
        line.append(time, ` ${text}`);
        return line;
      }));
    }
    put(one("air"), view.chambers.map((air) => `${air.name}: ${air.silence || `${air.temperature_degc === null ? "—" : air.temperature_degc.toFixed(2)} °C, set ${air.setpoint_degc === null ? "—" : air.setpoint_degc.toFixed(2)} °C`}`).join(" · "));
  };

  const tables = new Map();
  const table = (name, channels) => {
    if (!tables.has(name)) {
      const node = document.createElement("section"), head = document.createElement("h3"), rows = document.createElement("table");
      node.className = "sensor";
      head.textContent = name;
      rows.innerHTML = "<thead><tr><th>Channel</th><th class=n>Mean</th><th class=n>Deviation</th><th class=n>n</th></tr></thead><tbody></tbody>";
      channels.forEach(() => rows.tBodies[0].insertRow().append(...Array.from({ length: 4 }, (_, n) => {
        const cell = document.createElement("td");
        if (n) cell.className = "n";
        return cell;
      })));
      node.append(head, rows);
      one("readings").append(node);
      tables.set(name, node);
    }
    return tables.get(name);
  };
  const read = () => {
    const chosen = one("sensor").value, rest = new Map(view.channels.map((channel) => [channel.name, channel]));
    const groups = Object.entries(sensors).map(([name, channels]) => [name, channels.filter((channel) => rest.has(channel))]);
    groups.forEach(([, channels]) => channels.forEach((channel) => rest.delete(channel)));
    if (rest.size) groups.push(["other channels", [...rest.keys()]]);
    const all = new Map(view.channels.map((channel) => [channel.name, channel]));
    for (const [name, channels] of groups) {
      const node = table(name, channels), rows = node.querySelector("tbody").rows;
      node.hidden = Boolean(chosen) && chosen !== name;
      channels.forEach((channel, n) => {
        const found = all.get(channel), [first, mean, sd, count] = rows[n].cells, unit = found.unit.split("_")[0] === "v" ? "V" : found.unit;
        put(first, channel.split(".").pop());
        first.title = channel;
        if (found.silence) {
          put(mean, "silent");
          mean.title = found.silence;
        } else put(mean, found.mean === null ? "—" : `${signed(found.mean, 6)} ${unit}`);
        put(sd, found.sd === null ? "—" : found.sd.toPrecision(2));
        put(count, found.overloads ? `${found.n} (${found.overloads} over)` : String(found.n));
      });
    }
  };
  one("sensor").addEventListener("change", () => { if (view) read(); });
  document.querySelectorAll("#bench > .acts [data-act]").forEach((button) => button.addEventListener("click", () => order(button.dataset.act, "")));

  const standing = (holder) => {
    const was = isMine;
    isMine = Boolean(holder) && holder.client === me;
    if (was && !isMine) let_go();
    if (!was && isMine) say("");
    put(one("who"), isMine ? "YOURS" : holder ? "TAKEN" : "FREE");
    put(one("doing"), `${isMine ? "you have the bench" : holder ? `${holder.name} has the bench` : "nobody has the bench"}${!view ? "" : view.stopping ? " · STOPPING: every axis was told to stop" : view.doing ? ` · ${view.doing}` : ""}${view && view.waits ? ` · ${view.waits}` : ""}`);
    one("state").className = `banner ${isMine ? "running" : holder ? "held" : ""}`;
    if (take) take.hidden = isMine;
    if (give) give.hidden = !isMine;
    document.querySelectorAll(".own").forEach((button) => { button.disabled = !isMine; });
  };
  const hear = (news) => {
    heard = performance.now();
    if (news.you) {
      me = news.you;
      standing(null);
      if (news.owner) [one("who").textContent, one("doing").textContent] = ["IN USE", `by ${news.owner}`];
    }
    if (news.told) say(news.told, true);
    if (news.axes) {
      view = news;
      show();
      standing(news.holder);
    }
    if (news.tick) {
      tick = news.tick;
      if (isMine) beat();
    }
    if (news.closed !== undefined) {
      view = null;
      say(news.closed, true);
      standing(null);
    }
    look();
  };
  const look = () => {
    const isOpen = socket && socket.readyState === WebSocket.OPEN, age = (performance.now() - heard) / 1000;
    const isLate = !isOpen || (view !== null && age > 1);
    fresh.classList.toggle("stale", isLate);
    put(fresh, isLate ? `NOT HEARD for ${age.toFixed(0)} s${isTrying ? ", trying again" : ""}` : "● live");
  };
  if (take) take.addEventListener("click", () => {
    if (send({ say: "take" })) say("taking the bench: its devices are opened");
    else say("not connected; nothing was done", true);
  });
  if (give) give.addEventListener("click", () => send({ say: "give" }));

  const listen = () => {
    isTrying = true;
    socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/jog/${rig}`);
    socket.onopen = () => { pause = 500; send({ csrf: bench.dataset.csrf }); look(); };
    socket.onmessage = (event) => hear(JSON.parse(event.data));
    socket.onclose = (event) => {
      let_go();
      view = null;
      standing(null);
      [one("who").textContent, one("doing").textContent] = ["NOT HEARD", "whether anything moves is not known here"];
      isTrying = event.code !== 1008 && event.code !== 1013;
      if (event.code === 1013) {
        say("put aside: too many pages of benches are open, and this one was silent for longest; touch it, and it listens again", true);
        window.addEventListener("pointerdown", listen, { once: true });
      }
      if (isTrying) {  // who has no session any more was told so, and enters anew
        setTimeout(listen, pause);
        pause = Math.min(2 * pause, 10000);
      }
      look();
    };
  };
  setInterval(look, 500);
  listen();
})();
