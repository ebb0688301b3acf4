"""Pages for browsers: one HTML file that needs no network, and the parts that pages are made of."""
