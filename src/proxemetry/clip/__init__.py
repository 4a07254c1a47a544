"""Clips: frames that share a camera, and who is who over time; knows scenes, never a network."""
