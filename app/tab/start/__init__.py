"""How a tab begins, and how it comes back: what is opened, planned and preferred at first."""
