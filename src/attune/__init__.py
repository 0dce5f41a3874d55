"""Attune: talk to a household robot, interrupt it at any moment, and be understood."""

__version__ = "0.1.0"
