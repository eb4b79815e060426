"""`warm_pytest` over a package whose modules are mutated as they are imported."""

from __future__ import annotations

import sys

from . import python_switch, warm_pytest
from .python_sources import MutatedSources, package_folder

if __name__ == "__main__":
    MutatedSources(package_folder()).install(python_switch)
    sys.exit(warm_pytest.main(sys.argv[1:]))
