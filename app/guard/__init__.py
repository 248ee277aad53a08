"""Protection of the page: token, policy, limits, sockets, uploads, the check at the start."""
