"""The claims of the three source papers, computed anew: one paper a file, found by scanning this folder."""
