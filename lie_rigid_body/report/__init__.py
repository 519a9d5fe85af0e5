"""A score as users see it: the options that ask for it, the table, the JSON, the picture and the page.

`write_plot` and `write_report` draw a score. `request` holds what the command line asks for, of an estimate in a bag or
on a topic, and answers with the score.
"""

from lie_rigid_body.report.drawing import write_plot, write_report

__all__ = ["write_plot", "write_report"]
