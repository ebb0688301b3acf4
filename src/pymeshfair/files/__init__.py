"""Reads, checks and writes mesh files, one module for each format or family of formats."""
