"""Facts about MeshLab: its filters, what they were called before, and what the installed pymeshlab says of them."""
