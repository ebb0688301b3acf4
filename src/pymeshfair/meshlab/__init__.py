"""Facts about MeshLab: its filters, their former names, and the filters of the installed pymeshlab."""
