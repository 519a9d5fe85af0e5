"""Recordings, certificates and scores as users see them: tables, JSON, pictures and pages.

- `recording_picture`: the picture of a recording, by Matplotlib;
- `motion_figures`, `residual_figures`: the figures of pages, by plotly.js;
- `recorded_motion`, `plotly_parts`: the geometry and the parts that these share;
- `certificate_text`, `certificate_page`: a certificate;
- `overview`: the verdicts on many bags;
- `scores`, `score_picture`: a score;
- `diagnoses`: what is wrong with a filter;
- `drawing`: pictures in the formats of files;
- `request`: what is asked for of a score, by a command line or, as `write_plot` and `write_report`, from Python;
- `html_page`: the frame of a page.
"""

from lie_rigid_body.report.request import write_plot, write_report

__all__ = ["write_plot", "write_report"]
