"""The computing processes: what they are asked, which works on what, how they are kept alive."""
