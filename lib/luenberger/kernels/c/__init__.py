"""C99: how functions, numbers and stage lists are written in it.

What writes a statement of C enters here; what a device keeps and when it is called is
said in `export`.
"""
