"""The gallery: the pages of `woodcock_client/web`, served as files."""
