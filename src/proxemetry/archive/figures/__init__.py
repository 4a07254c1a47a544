"""What is made of the results: summaries, charts, exports, overlays."""
