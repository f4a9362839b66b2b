"""C99: how programs, numbers and functions are written in it.

What writes a statement of C enters here; what a device keeps and when it is called is
said in `export`.
"""

from .file import File as File
from .file import function as function
from .module import Module as Module
from .writer import C as C
