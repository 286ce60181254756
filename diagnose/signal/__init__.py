"""Signal processing as free functions: arrays in, arrays and small data classes out."""
