"""Everything that touches viser's private side, and the link to the scripts of the page."""
