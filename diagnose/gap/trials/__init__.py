"""Blind trials of the gap engine: hidden causes in simulated campaigns, and how well they are found."""
