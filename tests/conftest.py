"""Settings all tests share."""

import os

from hypothesis import settings

# machines differ in speed, and a build must not depend on luck: new cases are hunted at the desk
settings.register_profile("desk", deadline=None)
settings.register_profile("build", deadline=None, derandomize=True)
settings.load_profile("build" if os.environ.get("CI") else "desk")
