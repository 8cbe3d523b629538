"""Settings of all unit tests: property tests find the same examples in every run and have no deadline."""
import hypothesis

hypothesis.settings.register_profile('repeatable', derandomize=True, database=None, deadline=None)
hypothesis.settings.load_profile('repeatable')
