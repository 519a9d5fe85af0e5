"""Recordings, certificates and scores as users see them: tables, JSON, pictures and pages.

- `certificates`, `overview`: a certificate, and the verdicts on many bags;
- `scores`: an estimate or several, with their picture by Matplotlib;
- `filters`: what is wrong with a filter, and the league;
- `campaign_scores`: the estimators of a campaign;
- `recording_picture`: the picture of a recording, by Matplotlib;
- `figures`, `html_page`: the figures of a recording, of which plotly.js draws the film, and the frame of a page;
- `recorded_motion`: what is drawn of a long recording, its samples and residuals, and the geometry that these share;
- `notebook`: what a notebook shows of a result;
- `answer`: the model of an answer, which the first four make, as text and as HTML;
- `drawing`: colours and axes, and pictures in the formats of files;
- `outputs`: the files of a verb, and its answer on stdout;
- `score_options`: the options of ``evaluate``;
- `files`: `write_plot` and `write_report` from Python.
"""

from lie_rigid_body.report.files import write_plot, write_report

__all__ = ["write_plot", "write_report"]
