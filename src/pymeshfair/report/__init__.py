"""Pages for browsers, each in one HTML file that needs no network, and the parts from which pages are built."""
