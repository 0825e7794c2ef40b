"""`--scheduler` on the command line: what it refuses."""

import subprocess
import sys


def _run(*words):
    run = [sys.executable, "-m", "calibore", "profile", *words]
    return subprocess.run(run, capture_output=True, text=True, check=False)


def test_threads_and_a_scheduler_together_are_wrong_usage(tmp_path):
    done = _run(str(tmp_path), "--out", str(tmp_path / "out"), "--workers", "2", "--scheduler", "tcp://127.0.0.1:9")
    assert done.returncode == 2
    assert "either --workers" in done.stderr
    assert not (tmp_path / "out").exists()
