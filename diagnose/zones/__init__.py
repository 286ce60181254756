"""Zone tables as data files, one file a standard."""
