"""How robots and designs look: meshes, colours, titles, the timeline."""
