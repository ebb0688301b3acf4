"""Facts about MeshLab: its filters, their former names, and those with another result each time; in files of JSON."""
