"""Building blocks of rotating machines: rolling bearings, and what later machines are made of."""
