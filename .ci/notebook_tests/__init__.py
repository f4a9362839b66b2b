"""Notebooks as tests: what strict nbval does not see, for any repository.

`refresh` runs a notebook and stores it; `stored` says what is wrong with one that is
stored; `prose` compares numbers in sentences with those that the cells print;
`in_pytest` makes pytest ask all of this; `forked` starts kernels faster.
Nothing here knows the project it serves.
"""
