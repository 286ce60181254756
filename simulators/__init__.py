"""What a machine does: kinematics, physics and synthetic signals. Imports nothing else of rotorwise."""
