"""Helpers that the modules of the package share."""
