"""Reproduces the shipped encoder from public packages: ``python -m tools.train`` (extra ``[train]``)."""
