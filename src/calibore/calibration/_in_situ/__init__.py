"""A rig against a profile of the same pipe, measured by other means."""
