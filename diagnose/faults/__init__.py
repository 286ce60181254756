"""One fault family a file; found by scanning this folder.

A module defines ``judge(now, baseline) -> list[Finding]`` with ``now`` and ``baseline`` (or None) as
``rotorwise.diagnose.observe.Observation``. A rule states a probability for each fault that it has evidence for and
says nothing otherwise. No rule knows another; ``evidence.py`` ranks them.
"""
