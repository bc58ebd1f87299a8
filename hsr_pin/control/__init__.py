"""The arm in the hands of a controller."""
