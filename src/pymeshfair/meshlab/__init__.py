"""Loads pymeshlab and calls its filters; holds facts about the filters, their former names and repeatability in JSON."""
