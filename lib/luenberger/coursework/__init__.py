"""Answers of students: read kindly, and chains marked line by line.

The checks of an assignment read answers through here.  The same mathematics in another
form is taken as it is meant: letters by their names, text, brackets, lists of one
entry.  What cannot be read is an AssertionError that says what was expected and what
was given.

Another kind of answer enters in `answers` or, if it has several entries, in `tables`;
`lessons` compares answers, `chains` marks what is handed in as lines, and `variants`
gives each student numbers of their own.  It uses `matrixproof`.
"""

from .answers import choice as choice
from .answers import expression as expression
from .answers import number as number
from .answers import numbers as numbers
from .chains import Marks as Marks
from .chains import mark_lines as mark_lines
from .lessons import same as same
from .lessons import spot as spot
from .tables import array as array
from .tables import by_name as by_name
from .tables import choices as choices
from .tables import instance as instance
from .tables import matrix as matrix
from .variants import identifier as identifier
from .variants import pick as pick
