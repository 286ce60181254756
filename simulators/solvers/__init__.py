"""How a machine's motion is computed: time stepping, harmonic balance, stability, and an independent check."""
