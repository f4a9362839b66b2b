"""Reduced-order state observers, derived in SymPy and run in NumPy."""
