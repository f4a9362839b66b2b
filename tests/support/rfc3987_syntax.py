"""Stands in for a package that nbval loads with nbformat, and that takes seconds.

That one is a grammar of addresses for jsonschema, which does without where it finds no
such function; notebooks hold none of these addresses.
"""
