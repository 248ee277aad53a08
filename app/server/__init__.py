"""The command, the server, who may enter it, and the page it serves."""
