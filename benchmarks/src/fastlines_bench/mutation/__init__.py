"""Mutation score: small faults in the code, one at a time, and whether a test notices each of them."""
