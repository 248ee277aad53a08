"""Appearance of robots and designs: meshes, colours, titles, the timeline."""
