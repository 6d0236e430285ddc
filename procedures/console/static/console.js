// The changing part of a run's page, and the picture of residuals. Everything here is comfort: the page is whole without.
"use strict";
(() => {
  const place = document.getElementById("standing"), fresh = document.getElementById("fresh");
  const picture = document.getElementById("picture"), canvas = document.getElementById("map");
  const banner = document.getElementById("banner"), under = document.getElementById("under"), run = encodeURIComponent(place.dataset.run);
  let aside = "", heard = performance.now(), pause = 500, shown = -1, drawn = null, waits = 0, isDue = false, label = 0;

  const tell = () => {
    const age = (performance.now() - heard) / 1000;
    fresh.classList.toggle("stale", age > 5 || aside !== "");
    fresh.textContent = aside ? `NOT FOLLOWED: ${aside}` : age > 5 ? `STALE for ${age.toFixed(0)} s, trying again` : "● live";
  };

  const put = (where, html) => {  // what is open stays open
    const open = [...where.querySelectorAll("details")].map((one) => one.open);
    where.innerHTML = html;
    where.querySelectorAll("details").forEach((one, n) => { if (n in open) one.open = open[n]; });
  };

  const listen = () => {
    const socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/live/${run}`);
    socket.onmessage = (event) => {
      heard = performance.now();
      aside = "";
      pause = 500;
      const news = JSON.parse(event.data);
      if (news.html !== undefined) {
        put(banner, news.banner);
        put(place, news.html);
        const first = banner.querySelector(".state b");
        if (first) document.title = document.title.replace(/^[A-Z]+ /, `${first.textContent} `);
        if (news.done !== shown) { shown = news.done; look(); }
      }
      if (news.acts !== undefined) offer(news.acts);
      tell();
    };
    socket.onclose = (event) => {
      aside = event.code === 1013 ? event.reason : "";
      if (aside) window.addEventListener("pointerdown", listen, { once: true });  // who asked by itself would put aside another
      else {
        setTimeout(listen, pause);
        pause = Math.min(2 * pause, 10000);
      }
      tell();
    };
  };

  const acts = document.getElementById("acts");
  let offered = null, isBusy = false;
  const offer = (html) => {  // not under a hand: what is being typed or held stays until it is done
    offered = html;
    if (isBusy || acts.contains(document.activeElement) && document.activeElement.value) return;
    const said = document.getElementById("said"), [text, kind] = [said.textContent, said.className];
    put(acts, html);
    document.getElementById("said").textContent = text;
    document.getElementById("said").className = kind;
    offered = null;
  };

  const say = (text, isRefused) => {
    const said = document.getElementById("said");
    said.textContent = text;
    said.classList.toggle("refused", isRefused);
  };

  let number = 0;
  const act = async (form) => {
    number += 1;
    isBusy = true;
    if (await postAct(form, form.dataset.act, `${form.elements.key.value}-${number}`, say)) form.reset();
    isBusy = false;
    if (offered !== null) offer(offered);
  };

  acts.addEventListener("submit", (event) => {
    event.preventDefault();
    if (event.target.dataset.hold === undefined) act(event.target);
  });
  const HOLD_MS = 500;  // against a touch by accident; the stop itself can be taken up again
  let holding = 0;
  const press = (event) => {
    const button = event.target.closest("[data-hold] button");
    if (!button || event.repeat || (event.type === "keydown" && event.key !== " " && event.key !== "Enter")) return;
    isBusy = true;
    button.classList.add("held");
    clearTimeout(holding);
    holding = setTimeout(() => { holding = 0; button.classList.remove("held"); act(button.form); }, HOLD_MS);
  };
  const release = () => {
    if (!holding) return;
    clearTimeout(holding);
    holding = 0;
    isBusy = false;
    acts.querySelectorAll(".held").forEach((one) => one.classList.remove("held"));
    say("hold it for half a second: then every axis stops at once", false);
  };
  acts.addEventListener("pointerdown", press);
  acts.addEventListener("keydown", press);
  for (const kind of ["pointerup", "pointercancel", "keyup", "blur"]) window.addEventListener(kind, release);

  const look = () => {  // at most every five seconds, however fast dwells come
    isDue = true;
    if (waits) return;
    waits = setTimeout(async () => {
      isDue = false;
      try {
        const answer = await fetch(`/api/v1/runs/${run}/map`);
        if (answer.ok) drawn = await answer.json();
      } catch { /* the socket tells that nothing is heard */ }
      draw();
      setTimeout(() => { waits = 0; if (isDue) look(); }, 5000);
    }, 50);
  };

  const draw = () => {
    picture.hidden = !drawn;
    if (!drawn) return;
    const rows = drawn.arcsec.length, columns = drawn.steps.length, ratio = window.devicePixelRatio || 1;
    const style = getComputedStyle(canvas), wide = canvas.clientWidth;
    const tall = Math.max(160, Math.min(26 * rows + 24, 640));
    canvas.width = wide * ratio;
    canvas.height = tall * ratio;
    canvas.style.height = `${tall}px`;
    const pen = canvas.getContext("2d");
    pen.scale(ratio, ratio);
    pen.clearRect(0, 0, wide, tall);
    const sizes = drawn.arcsec.flatMap((row) => row.filter((one, n) => one !== null && drawn.marks[n] !== "x").map(Math.abs));
    sizes.sort((a, b) => a - b);
    const most = Math.max(sizes[Math.floor(0.98 * (sizes.length - 1))] || 1, 1e-6);
    const height = (tall - 20) / rows;
    pen.font = `${Math.min(13, Math.max(9, height - 4))}px system-ui, sans-serif`;
    pen.textBaseline = "middle";
    const names = drawn.channels.map((one) => one.split(".").pop());
    label = Math.min(8 + Math.max(...names.map((one) => pen.measureText(one).width)), wide * 0.3);
    const width = (wide - label) / columns;
    drawn.arcsec.forEach((row, r) => {
      pen.fillStyle = style.color;
      pen.fillText(names[r], 2, (r + 0.5) * height, label - 6);
      row.forEach((one, c) => {
        if (one === null) return;
        const share = Math.max(-1, Math.min(1, one / most)), strong = Math.sqrt(Math.abs(share));
        pen.fillStyle = share < 0 ? `rgba(0,114,178,${strong})` : `rgba(213,94,0,${strong})`;
        pen.fillRect(label + c * width, r * height + 0.5, Math.max(width - (width > 4 ? 0.5 : 0), 0.6), height - 1);
      });
    });
    pen.fillStyle = style.color;
    pen.font = "10px system-ui, sans-serif";
    pen.textAlign = "center";
    [...drawn.marks].forEach((mark, c) => {
      const sign = { x: "✕", r: "●" }[mark];
      if (sign) pen.fillText(sign, label + (c + 0.5) * width, tall - 9);
    });
    under.textContent = `${columns} dwells, steps ${drawn.steps[0]} to ${drawn.steps[columns - 1]}; full colour from ±${most.toPrecision(2)}″.`;
  };

  canvas.addEventListener("pointermove", (event) => {
    if (!drawn) return;
    const box = canvas.getBoundingClientRect();
    const c = Math.floor((event.clientX - box.left - label) / (box.width - label) * drawn.steps.length);
    const r = Math.floor((event.clientY - box.top) / (box.height - 20) * drawn.channels.length);
    const value = (drawn.arcsec[r] || [])[c];
    if (value !== undefined) under.textContent = `${drawn.channels[r]}, step ${drawn.steps[c]}: ${value === null ? "no reading" : `${value}″`}`;
  });
  window.addEventListener("resize", draw);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  setInterval(tell, 1000);
  listen();
  look();
})();
