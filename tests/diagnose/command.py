"""Runs `rotorwise` inside the test's process: the same entry point, words, streams and exit code, without its start.

Starting Python and its libraries anew costs a second a call; `test_cli.py` does that, to see the installed command.
"""

from __future__ import annotations

import contextlib
import io
import os
import subprocess
import sys
from pathlib import Path
from unittest import mock

from rotorwise.diagnose import cli


def run(*words: object, cwd: Path | None = None, environment: dict[str, str] | None = None) -> Done:
    """Return what the command prints and its exit code; a crash is a test's failure."""
    out, err = io.StringIO(), io.StringIO()
    arguments = ["rotorwise", *map(str, words)]
    with (
        contextlib.chdir(cwd or Path.cwd()),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
        mock.patch.object(sys, "argv", arguments),
        mock.patch.dict(os.environ, environment or {}),
        mock.patch.object(cli, "_leave", sys.exit),
    ):
        try:
            cli.main()
            code = 0
        except SystemExit as ended:
            code = int(ended.code or 0)
    return subprocess.CompletedProcess(arguments, code, out.getvalue(), err.getvalue())


Done = subprocess.CompletedProcess[str]
