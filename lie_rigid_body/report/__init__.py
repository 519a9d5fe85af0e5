"""Recordings, certificates and scores as users see them: tables, JSON, pictures and pages.

- `recording_picture`: the picture of a recording, by Matplotlib;
- `motion_figures`, `residual_figures`: the figures of pages, by plotly.js;
- `recorded_motion`, `plotly_parts`: the geometry and the parts that these share;
- `certificate_text`, `certificate_page`: a certificate;
- `overview`: the verdicts on many bags;
- `scores`, `score_picture`: a score;
- `diagnoses`: what is wrong with a filter;
- `drawing`: pictures and pages as files, such as `write_plot` and `write_report` make of a score;
- `request`: what the command line asks for, of an estimate in a bag or on a topic;
- `html_page`: the frame of a page.
"""

from lie_rigid_body.report.drawing import write_plot, write_report

__all__ = ["write_plot", "write_report"]
