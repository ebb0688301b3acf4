"""Files that lie, as tables, a format each: ``{}`` in a message stands for the name of the file."""
