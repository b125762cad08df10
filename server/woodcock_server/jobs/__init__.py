"""Jobs: renders that were asked for."""
