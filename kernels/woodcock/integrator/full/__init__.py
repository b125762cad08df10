"""What the full loop is made of: device code in parts, chosen by what a scene uses, and text that calls its kinds."""
