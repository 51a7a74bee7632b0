"""Finds the tip of an instrument in an X-ray picture: a small network that learns from a data set of the factory
(docs/tracker.md). The package needs PyTorch, NumPy and Pillow, and does not need cournand."""
