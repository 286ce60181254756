"""The machines that rotorwise ships, one a file: each defines a `DEFINITION`, found by scanning this folder."""
