"""The settings of a build: split sets, costs, limits and the named trees."""
