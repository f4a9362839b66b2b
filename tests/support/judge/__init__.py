"""What differs between the code under test, exact arithmetic, and an older checkout.

python tests/support/judge exact --count 20000
python tests/support/judge notebooks --against HEAD
python tests/support/judge timings --against HEAD
"""
