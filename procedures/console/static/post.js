// One act of a page, sent until it is answered: the same key counts once, so a try whose answer was lost does no harm.
"use strict";
const FIRST_TRY_MS = 4000, LONGEST_TRY_MS = 32000, PATIENCE_MS = 900;

const postAct = async (form, name, key, say) => {
  const body = new URLSearchParams(new FormData(form));
  body.set("key", key);
  say(`${name}: asked, waiting for an answer`, false);
  for (let tries = 1; ; tries += 1) {
    const patience = setTimeout(() => { if (tries === 1) say(`${name}: no answer yet; still waiting, and trying again`, true); }, PATIENCE_MS);
    try {
      const most_ms = Math.min(FIRST_TRY_MS * 2 ** (tries - 1), LONGEST_TRY_MS);  // a slow network answers a patient try
      const answer = await fetch(form.action, { method: "POST", body, headers: { accept: "application/json" }, signal: AbortSignal.timeout(most_ms) });
      if (answer.status === 503) throw new Error("no place");
      const isDocument = (answer.headers.get("content-type") || "").startsWith("application/json");
      const news = isDocument ? await answer.json() : { done: false, told: (await answer.text()).trim() };
      say(news.told, !news.done);
      return news.done;
    } catch {
      say(`${name}: NOT answered after ${tries} ${tries === 1 ? "try" : "tries"}; trying again; use the button at the machine`, true);
      await new Promise((go) => setTimeout(go, 500));
    } finally {
      clearTimeout(patience);
    }
  }
};
