// SPDX-License-Identifier: Apache-2.0
// What every page behind a token has: the token of the address, what is shown without one, and notices.

const NOTICE_MS = { good: 5000, bad: 15000 };
let noticeTimer = 0;

/** Without the token there is nothing to see. */
function needed(why, who = "The run") {
  byId("entry").hidden = false;
  byId("entry-why").textContent =
    shown(`${why}. ${who} prints an address with a token in it; open that, or give the token here.`);
  document.documentElement.dataset.ready = "refused";
}

/** Begins a page: with the token, if there is one; and again with another one. */
function enter(open, what, who) {
  byId("entry").addEventListener("submit", (event) => {
    event.preventDefault();
    sessionStorage.setItem("token", byId("token").value.trim());
    location.reload();
  });
  addEventListener("hashchange", () => { if (location.hash.includes("token=")) location.reload(); });
  const token = tokenHere();
  if (token) open(token).catch((error) => needed(`the page could not be drawn (${error.message})`, who));
  else needed(`This page shows ${what} to those who have its token`, who);
}

/** The token of the address; it is taken out of the address, and kept for this window alone. */
function tokenHere() {
  const given = new URLSearchParams(location.hash.slice(1)).get("token");
  if (given) {
    sessionStorage.setItem("token", given);
    history.replaceState(null, "", location.pathname);
  }
  return given || sessionStorage.getItem("token") || "";
}

/** Puts a notice over the page; one that is good or bad leaves by itself, any other stays until the next. */
function notify(words, kind) {
  const element = byId("notice");
  element.hidden = false;
  element.className = kind;
  element.textContent = shown(words);
  clearTimeout(noticeTimer);
  const stays = NOTICE_MS[kind];
  if (stays) noticeTimer = setTimeout(() => { element.hidden = true; }, stays);
}
