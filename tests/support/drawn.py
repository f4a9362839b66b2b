"""How many examples hypothesis draws, and whether they are new ones.

CI draws the same few every time.  The long run draws twenty times as many, others in
each run, and prints how a failing one is drawn again; `.github/CONTRIBUTING.md` has
its command.
"""

from hypothesis import HealthCheck, settings

LONGER = 20

settings.register_profile("long", print_blob=True, database=None)


def bounded(examples):
    """The same examples on every machine, few enough, and no clock in the verdict."""
    long = settings.get_current_profile_name() == "long"
    return settings(
        derandomize=not long,
        max_examples=LONGER * examples if long else examples,
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
    )
