// Before viser's own script: it takes all of the address for its server's, the #fragment too, and
// then connects to none. Ours is kept here, and leaves the address.
(() => {
  window.llsrbmFragment = location.hash;
  const address = location.pathname + location.search;
  if (!location.href.endsWith(address)) history.replaceState(null, "", address);
})();
