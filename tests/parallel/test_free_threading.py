"""Free-threaded builds of Python; the other tests of this folder run there, too (`.ci/platforms threads`)."""

import subprocess
import sys
import sysconfig

import pytest

PROGRAM = """
import sys
import fastlines as fl
fl.build([[[0, 0, 0], [1, 1, 1]]]).first_hit([0, 0, -1], [0, 0, 1], 0.1)
print(sys._is_gil_enabled())
"""


@pytest.mark.skipif(not sysconfig.get_config_var("Py_GIL_DISABLED"), reason="this Python has a GIL")
def test_modules_do_not_bring_the_gil_back() -> None:
    done = subprocess.run([sys.executable, "-W", "error", "-c", PROGRAM], capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == ("False\n", "")
