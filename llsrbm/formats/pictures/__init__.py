"""A motion to look at: a page that plays from disk, videos."""
