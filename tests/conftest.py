"""Settings all tests share."""

import os

from hypothesis import settings

# machines differ in speed, and a build must not depend on luck: new cases are hunted by HUNT=1 pytest
settings.register_profile("hunt", deadline=None)
settings.register_profile("build", deadline=None, derandomize=True)
settings.load_profile("hunt" if os.environ.get("HUNT") else "build")
