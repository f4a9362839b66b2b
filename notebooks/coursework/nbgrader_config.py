"""Settings of the course; README.md beside this file says how it runs."""

c = get_config()  # noqa: F821  nbgrader defines it

c.CourseDirectory.course_id = "luenberger"

# A cell that runs longer is interrupted and scores nothing; the next cell runs.
c.Execute.timeout = 20

# A check that was deleted comes back, as one that was edited does anyway.
c.OverwriteCells.add_missing_cells = True
