"""Measure how far apart people stand in ordinary photographs."""

__version__ = "0.1.0"
