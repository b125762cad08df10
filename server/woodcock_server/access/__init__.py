"""Who may ask the service for what, and from where."""
