"""Theorems that several papers use, proved once; each has them in its letters.

`observer`
    What drives the error of any observer, and of its estimate.
`regression`
    The gain of least covariance, alone or under a condition.
"""
