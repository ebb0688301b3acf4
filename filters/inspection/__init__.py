"""Looking at a surface: numbers, scalars and colours that say what it is like."""
