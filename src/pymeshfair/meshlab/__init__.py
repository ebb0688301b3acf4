"""Loads pymeshlab and calls its filters; JSON files hold facts about the filters, such as former names and repeatability."""
