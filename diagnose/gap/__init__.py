"""The model gap: what a simulated machine gets wrong about a measured one, its cause, and the gain of adding it."""
