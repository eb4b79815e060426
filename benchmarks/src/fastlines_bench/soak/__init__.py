"""The soak: random scenes, trees and queries, whose answers are compared with brute force, and that with float64."""
