"""Who may enter the page and how much each visitor may use: token, policy, limits, sockets."""
