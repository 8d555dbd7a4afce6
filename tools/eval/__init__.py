"""Experiments that regenerate the published tables."""
