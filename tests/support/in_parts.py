"""A record filtered in parts."""


def in_parts(run, parts):
    """What a `Filter` finds in each part of a record, each from the end of the last."""
    end = None
    for part in parts:
        found = run.run(part, start=end)
        end = found.end
        yield found
